#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "tools/audit/audit_scenario.h"

namespace muster::tools::audit {

/// A pair's sensing or charging, as the log says it.
struct Activity {
  ActivityKind kind = ActivityKind::kSensing;
  int uav = -1, partner = -1, site = -1;
  std::int64_t start_us = 0, end_us = 0;
  bool operator==(const Activity&) const = default;

  bool senses() const { return kind == ActivityKind::kSensing; }
  int partner_class() const { return senses() ? kWorker : kVehicle; }
  bool involves(int agent_kind, int id) const {
    return agent_kind == kUav ? uav == id : agent_kind == partner_class() && partner == id;
  }
  ActionKind action() const { return senses() ? ActionKind::kSense : ActionKind::kCharge; }
};

/// Where an agent must be and what range it must have left, by the audit's own arithmetic: legs at
/// the scenario's speed, range spent per metre flown and for sensing, gained by charging.
struct AgentModel {
  int kind = kUav;
  int id = -1;
  const Scenario::Agent* spec = nullptr;
  const Ways* ways = nullptr;      ///< now
  const Ways* leg_ways = nullptr;  ///< of its leg: those that it began with

  Place from, to;
  std::int64_t depart_us = 0, arrive_us = 0;
  std::int64_t hold_us = 0;  ///< that it waits at `from` before it sets out
  double range_at_departure_m = 0;
  double range_per_m = 1;  ///< more in wind, as seen in the reports
  bool way_seen = true;    ///< range_per_m of this leg is known
  ActionKind action = ActionKind::kNone;
  int target = -1, partner = -1, decision = -1;
  std::int64_t busy_until_us = 0;
  std::optional<Activity> activity;
  double cost_m = 0;  ///< of the activity, when it senses
  bool failed = false;
  bool joined_unheard =
      false;  ///< its process was lost when it joined, and has not been heard since
  /// As it was before its way was closed, while nobody has heard from it since: it may turn out to
  /// have failed before that. null: it was heard.
  std::shared_ptr<const AgentModel> unheard;
  Place was;  ///< where it truly was, as last known, and when
  std::int64_t was_us = 0;

  // Of a measured one. Where it was for sure, since it has said so or stood there, when and with
  // what range; where and when it set out on its leg, its arrival as planned then, by the ways of
  // the present; what its last report says.
  Place anchor;
  std::int64_t anchor_us = 0;
  double anchor_range_m = 0;
  Place origin;  ///< of its leg
  std::int64_t set_out_us = 0, planned_us = 0;
  bool says_arrived = false, says_done = false;
  bool overdue = false;         ///< what it does should be done by now
  bool goes_on_anew = false;    ///< its leg is not as planned: its rest begins at each report
  bool may_have_paid = false;   ///< to communicate, for a command of which its process told nothing
  bool cost_is_hidden = false;  ///< what it paid to communicate cannot be told from its way
  std::optional<double> range_after_m = {};  ///< that it has when it is done

  std::string name() const;
  bool pair() const { return action == ActionKind::kSense || action == ActionKind::kCharge; }
  Place At(std::int64_t t) const;
  /// Part of its leg that is behind it at t, 0 to 1.
  double PartAt(std::int64_t t) const;
  /// Metres; below 0 when the agent flew further than it could.
  double RangeAt(std::int64_t t) const;
  double RangeOnArrival() const {
    const double range_m = range_at_departure_m - range_per_m * leg_ways->Length(kind, from, to);
    return spec->measured ? std::max(0.0, range_m) : range_m;
  }
  /// Microseconds by which two right answers to when it arrives may differ.
  std::int64_t RoundingUs() const;
  /// Metres of the present leg behind it at t.
  double MovedAt(std::int64_t t) const { return leg_ways->Gone(kind, from, At(t)); }
  double WayM(Place a, Place b) const { return ways->Length(kind, a, b); }
  AgentStatus StatusAt(std::int64_t t) const;
  /// Stands where it is at t, free.
  void StopAt(std::int64_t t);
  /// Travels by these ways from now on, and makes the rest of its leg from there by them; it stops
  /// there, free, if there is none.
  void GoRound(const Ways& now, Place here, std::int64_t t);
  /// Is there for sure.
  void Anchor(Place at, std::int64_t t, double range_m) {
    anchor = at;
    anchor_us = t;
    anchor_range_m = range_m;
  }
};

/// Microseconds to cover `amount` at `rate` per second, rounded to nearest; kForever when it does
/// not fit.
std::int64_t DurationUs(double amount, double rate);

}  // namespace muster::tools::audit
