#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tools/audit/audit_scenario.h"

namespace muster::tools::audit {

/// Action kinds, as on the wire.
enum Kind : int {
  kNoAction = -1,
  kUavStays = 0,
  kWorkerStays = 1,
  kVehicleStays = 2,
  kUavToTask = 3,
  kWorkerToTask = 4,
  kUavToCharge = 5,
  kVehicleToCharge = 6,
  kSense = 7,
  kChargeUp = 8,
  kGoTo = 9,
};

/// A pair's sensing or charging, as the log says it.
struct Activity {
  int kind = 0;  ///< 0 sensing, 1 charging
  int uav = -1, partner = -1, site = -1;
  std::int64_t start_us = 0, end_us = 0;
  bool operator==(const Activity&) const = default;

  int partner_class() const { return kind == 0 ? kWorker : kVehicle; }
  int action() const { return kind == 0 ? kSense : kChargeUp; }
};

/// Where an agent must be and what range it must have left, by the audit's own arithmetic: straight
/// legs at the scenario's speed, range spent per metre flown and for sensing, gained by charging.
struct AgentModel {
  int kind = kUav;
  int id = -1;
  const Scenario::Agent* spec = nullptr;

  Place from, to;
  std::int64_t depart_us = 0, arrive_us = 0;
  double range_at_departure_m = 0;
  double range_per_m = 1;  ///< more in wind, as seen in the reports
  bool way_seen = true;    ///< range_per_m of this leg is known
  int action = kNoAction;
  int target = -1, partner = -1, decision = -1;
  std::int64_t busy_until_us = 0;
  std::optional<Activity> activity;
  double cost_m = 0;  ///< of the activity, when it senses
  bool failed = false;

  std::string name() const;
  bool pair() const { return action == kSense || action == kChargeUp; }
  Place At(std::int64_t t) const;
  /// Metres; below 0 when the agent flew further than it could.
  double RangeAt(std::int64_t t) const;
  double RangeOnArrival() const { return range_at_departure_m - range_per_m * Way(from, to); }
  /// Metres of the present leg behind it at t.
  double MovedAt(std::int64_t t) const { return Way(from, At(t)); }
  /// 0 offline, 1 idle, 2 moving, 3 waiting, 4 sensing, 5 charging, 6 failed.
  int StatusAt(std::int64_t t) const;
  /// Stands where it is at t, free.
  void StopAt(std::int64_t t);
};

/// Microseconds to cover `amount` at `rate` per second, rounded to nearest; kForever when it does
/// not fit.
std::int64_t DurationUs(double amount, double rate);

}  // namespace muster::tools::audit
