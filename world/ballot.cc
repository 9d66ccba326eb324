#include "world/ballot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "base/sha256.h"
#include "lcmtypes/bus/codec.h"

namespace muster::world {
namespace {

/// "scheduler-2 (7 actions, weight 3.25)"
std::string Text(const std::string& scheduler, const proposal_t& proposal) {
  return fmt::format("{} ({} actions, weight {:.6g})", scheduler, proposal.schedule.n,
                     proposal.schedule.weight);
}

}  // namespace

std::string DigestOf(const proposal_t& proposal) {
  proposal_t bare = proposal;
  bare.header = bare.schedule.header = header_t{};
  bare.schedule.solve_us = 0;
  for (clearances_t& clearances : bare.clearances) clearances.header = header_t{};
  bare.events.clear();
  bare.n_events = 0;
  const std::vector<std::uint8_t> bytes = Encode(bare);
  return Sha256({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

Ballot::Ballot(std::set<std::string> schedulers)
    : schedulers_(std::move(schedulers)), awaited_(schedulers_) {}

void Ballot::Open(TimeUs now_us) {
  votes_.clear();
  opened_us_ = now_us;
  first_us_ = kNever;
}

void Ballot::Cast(const std::string& scheduler, proposal_t proposal, TimeUs now_us) {
  if (first_us_ == kNever) first_us_ = now_us;
  std::string digest = DigestOf(proposal);
  votes_.insert_or_assign(scheduler, Vote{std::move(proposal), std::move(digest)});
}

TimeUs Ballot::due_us() const {
  return first_us_ == kNever ? kNever : first_us_ + std::max(kGraceUs, first_us_ - opened_us_);
}

std::optional<Ballot::Result> Ballot::Close(TimeUs now_us, const IsSound& is_sound) {
  if (votes_.empty()) return {};
  std::map<std::string_view, std::vector<std::string>> camps;  // by digest, names in order
  for (const auto& [scheduler, vote] : votes_) camps[vote.digest].push_back(scheduler);
  std::size_t most = 0;
  for (const auto& [digest, camp] : camps) most = std::max(most, camp.size());
  const bool is_majority = 2 * most > schedulers_.size();
  const bool all_there =
      std::all_of(awaited_.begin(), awaited_.end(),
                  [&](const std::string& name) { return votes_.contains(name); });
  if (!is_majority && !all_there && now_us < due_us()) return {};
  // A scheduler that is slow today is not waited for tomorrow, until it is in time again.
  if (!is_majority && !all_there) {
    std::erase_if(awaited_, [&](const std::string& name) { return !votes_.contains(name); });
  }
  std::vector<std::string> first;  // of the largest camps, one each
  for (const auto& [digest, camp] : camps) {
    if (camp.size() == most) first.push_back(camp.front());
  }
  std::string how = is_majority ? "by majority" : "by most votes";
  if (first.size() > 1) {
    std::vector<std::string> sound;
    for (const std::string& name : first) {
      if (is_sound(votes_.at(name).proposal)) sound.push_back(name);
    }
    how = sound.size() == 1 ? "as it alone passes the checker" : "by weight";
    if (!sound.empty()) first = std::move(sound);
  }
  const std::string by = *std::min_element(
      first.begin(), first.end(), [&](const std::string& a, const std::string& b) {
        const double of_a = votes_.at(a).proposal.schedule.weight;
        const double of_b = votes_.at(b).proposal.schedule.weight;
        return of_a != of_b ? of_a > of_b : a < b;
      });
  return Take(by, how);
}

Ballot::Result Ballot::Take(const std::string& by, const std::string& how) {
  const Vote& vote = votes_.at(by);
  Result result{by, vote.proposal, {}};
  Taken taken{by, vote.digest, Text(by, vote.proposal), {}};
  std::string others;
  for (const auto& [scheduler, other] : votes_) {
    awaited_.insert(scheduler);
    if (other.digest == vote.digest) continue;
    taken.differ.insert(scheduler);
    others += (others.empty() ? "" : ", ") + Text(scheduler, other.proposal);
  }
  const std::int32_t decision = vote.proposal.schedule.decision;
  if (!others.empty()) {
    result.dispute =
        fmt::format("decision {}: {} is taken {}, against {}", decision, taken.text, how, others);
  }
  taken_.insert_or_assign(decision, std::move(taken));
  return result;
}

std::string Ballot::Late(const std::string& scheduler, const proposal_t& proposal, TimeUs now_us) {
  const auto found = taken_.find(proposal.schedule.decision);
  if (found == taken_.end()) return "";
  Taken& taken = found->second;
  const bool is_newest = std::next(found) == taken_.end();
  if (is_newest && !votes_.empty() && now_us < due_us()) awaited_.insert(scheduler);
  if (DigestOf(proposal) == taken.digest || !taken.differ.insert(scheduler).second) return "";
  return fmt::format("decision {}: {} was taken, {} comes later and differs",
                     proposal.schedule.decision, taken.text, Text(scheduler, proposal));
}

}  // namespace muster::world
