#include "tools/launch/archive.h"

#include <set>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "lcmtypes/protocol/convert.h"
#include "world/truth/restoring.h"

namespace muster::tools {
namespace {

/// Ticks kept. The newest may have been told in part, and it takes the verdict on the one before.
constexpr std::size_t kTicks = 4;
constexpr TimeUs kPatienceUs = 2 * kSecondUs;
constexpr TimeUs kAgainUs = kSecondUs / 2;

bool IsVerdict(std::string_view name) {
  return name == channel::kWorld || name == channel::kRulings;
}
bool IsStates(std::string_view name) {
  return name == channel::kUavs || name == channel::kWorkers || name == channel::kVehicles;
}

restore_t Restore(std::string_view name, const std::vector<std::uint8_t>& bytes) {
  restore_t restore{};
  restore.channel = name;
  restore.data = bytes;
  restore.n = static_cast<std::int32_t>(bytes.size());
  return restore;
}

}  // namespace

Archive::Archive(const Scenario& scenario, std::int64_t run_id)
    : scenario_(scenario), run_id_(run_id) {}

void Archive::Add(const Packet& packet) {
  if (!IsStates(packet.channel) && !IsVerdict(packet.channel)) return;
  const std::optional<header_t> header = DecodeHeader(packet);
  if (!header || header->run_id != run_id_) return;
  Told& told = told_[packet.channel];
  told[header->sim_us].try_emplace({header->sender, header->boot_id, header->seq}, packet);
  while (told.size() > kTicks) told.erase(told.begin());
}

std::optional<TimeUs> Archive::Consistent() const {
  std::set<TimeUs, std::greater<>> times;
  for (const auto& [name, told] : told_) {
    if (!IsStates(name)) continue;
    for (const auto& [t, packets] : told) times.insert(t);
  }
  for (const TimeUs t : times) {
    world::Restoring restoring(scenario_, run_id_);
    for (const auto& [name, told] : told_) {
      for (const auto& [told_us, packets] : told) {
        if (!IsVerdict(name) && told_us != t) continue;
        for (const auto& [message, packet] : packets) {
          // One that is impossible lacks below.
          static_cast<void>(restoring.Take(Restore(name, packet.bytes)));
        }
      }
    }
    const auto state = restoring.Newest();
    if (state && scenario_.rules.TimeOf(state->tick) == t) return t;
  }
  return {};
}

std::vector<restore_t> Archive::Answer(const request_t& request, TimeUs now_us) {
  if (!IsStates(request.channel) && !IsVerdict(request.channel)) return {};
  Question& question = questions_[{request.header.sender, request.header.boot_id, request.channel}];
  if (question.asked_us == kNever || now_us - question.asked_us > kPatienceUs) {
    question.since_us = now_us;
  }
  question.asked_us = now_us;
  if (now_us - question.since_us < kPatienceUs || now_us - question.answered_us < kAgainUs) {
    return {};
  }
  question.answered_us = now_us;

  const std::optional<TimeUs> consistent = Consistent();
  if (!consistent && told_.find(channel::kWorld) != told_.end()) return {};
  std::vector<restore_t> answers;
  if (!consistent) {  // the mission has not begun
    if (!IsStates(request.channel)) return {};
    answers.push_back(Restore(request.channel, {}));
    answers.back().tick = -1;
    return answers;
  }
  const auto told = told_.find(request.channel);
  if (told == told_.end()) return {};
  for (const auto& [t, packets] : told->second) {
    if (IsStates(request.channel) && t != *consistent) continue;
    for (const auto& [message, packet] : packets) {
      answers.push_back(Restore(request.channel, packet.bytes));
      answers.back().tick = (t + scenario_.rules.tick_us - 1) / scenario_.rules.tick_us;
    }
  }
  return answers;
}

}  // namespace muster::tools
