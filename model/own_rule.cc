#include "model/own_rule.h"

#include <limits>

#include "model/feasibility.h"

namespace muster {

std::optional<Action> OwnAction(const AgentState& agent, TimeUs t, const Scenario& scenario) {
  if (agent.kind != AgentKind::kUav || !agent.idle(t) || scenario.separation() != nullptr)
    return {};
  const double range_m = RangeAt(agent, t, scenario.tasks);
  if (range_m >= kReserveShare * agent.range_full_m) return {};
  double nearest_m = std::numeric_limits<double>::infinity();
  Action action;
  for (std::size_t y = 0; y < scenario.charging_points.size(); ++y) {
    const Point at = scenario.charging_points[y].at;
    const double way_m = agent.WayM(agent.to, at);
    if (way_m >= nearest_m) continue;
    nearest_m = way_m;
    action.charge = ChargeId(y);
    action.to = at;
  }
  if (!action.charge.valid() || nearest_m <= 0 || !CanReachCharge(range_m, nearest_m)) return {};
  const TimeUs latest_us = LatestEnd(agent, scenario.rules);
  if (TravelUs(nearest_m, agent.speed_m_s) > latest_us - t) return {};
  action.kind = ActionKind::kUavToCharge;
  action.uav = UavId(agent.id);
  return action;
}

}  // namespace muster
