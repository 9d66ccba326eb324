#pragma once

#include <algorithm>
#include <span>

#include "model/agent.h"
#include "model/scenario.h"

namespace muster {

/// A UAV's way from `p` to the charging point that is nearest by way, metres; infinity when there
/// is none. Constraint (6)'s Opt_charge. Looks at every point; PlaceIndex is the indexed form.
double NearestChargeM(const Ways& ways, Point p, std::span<const ChargingPoint> points);

/// Constraint (5): range enough to reach the charging point.
inline bool CanReachCharge(double range_m, double way_m) { return way_m <= range_m; }

/// Constraint (6): range enough for the way, the sensing and the way from the task to its nearest
/// charging point.
inline bool CanSense(double range_m, double way_m, double cost_m, double to_charge_m) {
  return way_m + cost_m + to_charge_m <= range_m;
}

/// Whether an agent that sets out now and takes that long arrives before the task expires. Both
/// agents of a pair must: sensing begins at the later arrival. Source: ours.
inline bool CanBegin(const Task& task, TimeUs now_us, TimeUs travel_us) {
  return travel_us != kNever && task.AllowsStart(now_us + travel_us);
}

/// Duration of sensing, constraint (2): cost / UAV speed.
inline TimeUs SensingUs(double cost_m, double uav_speed_m_s) {
  return DurationUs(cost_m, uav_speed_m_s);
}

/// Duration of charging, constraint (4): the range that is missing on arrival / charging rate.
inline TimeUs ChargingUs(double missing_m, double charge_rate_m_s) {
  return DurationUs(missing_m, charge_rate_m_s);
}

/// The same of a UAV that arrives with so much range. Nothing is missing of more than a full range.
inline TimeUs ChargingUs(double range_full_m, double range_on_arrival_m, double charge_rate_m_s) {
  return ChargingUs(std::max(0.0, range_full_m - range_on_arrival_m), charge_rate_m_s);
}

/// Latest time at which an action of this agent may end under the availability mode: strict:
/// min(downtime, limit); overrun: kNever.
inline TimeUs LatestEnd(const AgentState& agent, const Rules& rules) {
  return rules.availability == Availability::kOverrun
             ? kNever
             : std::min(agent.online_until_us, rules.limit_us);
}

}  // namespace muster
