#include "tools/record/measured_legs.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/measured.h"

namespace muster::tools {

void MeasuredLegs::Take(const Scenario& scenario, AgentKind kind, std::int64_t tick,
                        const agent_t& agent) {
  if (!scenario.agents(kind)[static_cast<std::size_t>(agent.id)].measured) return;
  if (const std::int32_t decision = scenario.rules.DecisionAt(tick); decision >= 0) {
    Told& told = told_[{kind, agent.id, decision}];
    told.from = {agent.x_m, agent.y_m};
    told.speed_m_s = agent.speed_m_s;
  }
  const bool moves_or_there =
      agent.action != NumberOf(ActionKind::kNone) && agent.status != NumberOf(AgentStatus::kFailed);
  if (!moves_or_there || agent.arrive_us > scenario.rules.TimeOf(tick)) return;
  Told& told = told_[{kind, agent.id, agent.decision}];
  if (tick >= told.arrived_tick) return;
  told.arrived_tick = tick;
  told.arrived_us = agent.arrive_us;
}

std::vector<MeasuredLeg> MeasuredLegs::List(
    const Scenario& scenario, const std::map<std::int32_t, schedule_t>& schedules) const {
  std::vector<MeasuredLeg> legs;
  for (const auto& [key, told] : told_) {
    const auto schedule = schedules.find(key.decision);
    if (!told.from || schedule == schedules.end()) continue;
    for (const action_t& action : schedule->second.actions) {
      if (ByKind(key.kind, action.uav_id, action.worker_id, action.vehicle_id) != key.agent)
        continue;
      MeasuredLeg leg{key.kind, key.agent, key.decision, action.task_id, action.charge_id};
      leg.way_m = scenario.ways->Length(key.kind, *told.from, {action.x_m, action.y_m});
      leg.sent_us = scenario.rules.TimeOfDecision(key.decision);
      const TimeUs way_us = TravelUs(leg.way_m, told.speed_m_s);
      if (way_us < kMeasuredSlackUs) continue;
      leg.planned_us = leg.sent_us + way_us;
      if (told.arrived_tick != kNever) leg.arrived_us = told.arrived_us;
      legs.push_back(leg);
    }
  }
  return legs;
}

nlohmann::ordered_json ToJson(const std::vector<MeasuredLeg>& legs) {
  auto list = nlohmann::ordered_json::array();
  for (const MeasuredLeg& leg : legs) {
    const std::string agent = fmt::format("{}:{}", ToString(leg.kind), leg.agent);
    if (list.empty() || list.back()["agent"] != agent) {
      list.push_back({{"agent", agent}, {"legs", nlohmann::ordered_json::array()}});
    }
    nlohmann::ordered_json row = {{"decision", leg.decision},
                                  {"task", leg.task},
                                  {"charge", leg.charge},
                                  {"way_m", leg.way_m},
                                  {"sent_s", ToSeconds(leg.sent_us)},
                                  {"planned_s", ToSeconds(leg.planned_us)},
                                  {"arrived_s", nullptr}};
    if (leg.arrived_us) row["arrived_s"] = ToSeconds(*leg.arrived_us);
    list.back()["legs"].push_back(std::move(row));
  }
  return list;
}

}  // namespace muster::tools
