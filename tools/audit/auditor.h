#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/audit/checks.h"
#include "tools/audit/findings.h"
#include "tools/audit/intake.h"
#include "tools/audit/view.h"

namespace muster::tools::audit {

/// What the log shows, for comparison with what was reported.
struct Facts {
  std::string sha256;
  std::uint64_t seed = 0;
  std::map<std::int32_t, schedule_t> schedules;
  std::vector<event_t> events;  ///< sorted, without repeats
  std::vector<std::int8_t> task_status;
  std::vector<double> flown_m, final_range_m;  ///< [n_uavs]
  std::int64_t messages = 0;
  std::map<std::int32_t, std::int64_t> decided_us;  ///< mission time of each of the schedules
};

/// Checks a mission's log, packet by packet, against every invariant of docs/reference/audit.md. It
/// follows the agents by its own arithmetic from what was commanded and ruled, one tick after the
/// other, and compares each report, activity, status and event with that. Memory grows with agents,
/// decisions, events and gaps; a tick is dropped when it has been checked.
///
/// Checking of ticks stops at the first one that breaks an invariant, because later violations
/// would only follow from that one.
class Auditor {
 public:
  void Add(const Packet& packet);
  /// Call once, after the last packet. Returns the violations by mission time; empty: all
  /// invariants hold.
  const std::vector<Violation>& Finish();

  /// After Finish(): none when the log broke an invariant before its end.
  const std::optional<Facts>& facts() const { return facts_; }
  std::int64_t messages() const { return intake_.heard().messages; }
  std::int64_t duplicates() const { return intake_.heard().duplicates; }
  /// Packets on our channels that are no valid message: not a violation, unless a seq is missing.
  std::int64_t undecodable() const { return intake_.heard().undecodable; }
  std::int64_t ticks() const { return intake_.next_tick(); }
  std::int64_t decisions() const {
    return static_cast<std::int64_t>(intake_.heard().schedules.size());
  }
  /// Of UAVs that are kept apart; null: they are not.
  const View::Closest* closest() const {
    return view_ && view_->scenario.separation ? &view_->closest : nullptr;
  }
  /// After Finish: nothing is wrong but that the log ends before the mission's end: the mission
  /// still runs, or was broken off.
  bool holds_so_far() const { return intake_.breaks_off() && findings_.count() == 2; }
  /// When the mission ends, microseconds.
  std::int64_t limit_us() const { return view_ ? view_->scenario.limit_us : 0; }
  std::int64_t activities() const { return view_ ? view_->n_activities : 0; }

 private:
  void Begin(const TickFacts& tick);
  void CheckTick();
  void CheckSkipped();
  void GatherFacts();

  Findings findings_;
  std::vector<Packet> held_back_;  ///< until the scenario comes
  Intake intake_{&findings_};
  std::optional<View> view_;
  std::optional<ReportCheck> reports_;
  OrderCheck orders_;
  SignatureCheck signatures_;
  std::set<std::int32_t> skipped_;  ///< decisions that never were in force
  std::optional<Facts> facts_;
};

}  // namespace muster::tools::audit
