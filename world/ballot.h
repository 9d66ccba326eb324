#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <muster/proposal_t.hpp>
#include <optional>
#include <set>
#include <string>

#include "base/units.h"

namespace muster::world {

/// What two equal proposals have in common: SHA-256 over schedule and altitudes, without headers,
/// events and the time that it took.
std::string DigestOf(const proposal_t& proposal);

/// The proposals of several schedulers for one decision, and which of them is taken
/// (docs/reference/schedulers.md).
class Ballot {
 public:
  /// How long the others are waited for after the first proposal, unless that itself took longer.
  static constexpr TimeUs kGraceUs = 300'000;

  explicit Ballot(std::set<std::string> schedulers);

  bool IsOf(const std::string& scheduler) const { return schedulers_.contains(scheduler); }

  /// Forgets the proposals before, and takes those for a decision asked for at that time.
  void Open(TimeUs now_us);
  /// A scheduler that starts again may propose again; its newest proposal counts.
  void Cast(const std::string& scheduler, proposal_t proposal, TimeUs now_us);
  bool empty() const { return votes_.empty(); }
  /// When it can be closed whatever comes; kNever: nothing is proposed.
  TimeUs due_us() const;

  struct Result {
    std::string by;  ///< the scheduler whose proposal is taken
    proposal_t proposal;
    std::string dispute;  ///< who differs and what decided; "": all agree
  };
  /// Whether that proposal passes the independent checker.
  using IsSound = std::function<bool(const proposal_t&)>;
  /// The proposal to take; none: more proposals are waited for. Most votes count: at once where
  /// more than half of all schedulers agree, otherwise when none is waited for any more. Where as
  /// many agree on one as on another, the checker decides, then the higher weight, then the name.
  std::optional<Result> Close(TimeUs now_us, const IsSound& is_sound);

  /// Of a proposal that comes after its decision was taken: how it differs; "": it does not, or
  /// that is known.
  std::string Late(const std::string& scheduler, const proposal_t& proposal, TimeUs now_us);

 private:
  struct Vote {
    proposal_t proposal;
    std::string digest;
  };
  /// What was taken: by whom, and what is known to differ.
  struct Taken {
    std::string by, digest, text;
    std::set<std::string> differ;
  };
  Result Take(const std::string& by, const std::string& how);

  const std::set<std::string> schedulers_;
  std::set<std::string> awaited_;  ///< those that proposed in time for the newest decision
  std::map<std::string, Vote> votes_;
  TimeUs opened_us_ = 0, first_us_ = kNever;
  std::map<std::int32_t, Taken> taken_;  ///< by decision
};

}  // namespace muster::world
