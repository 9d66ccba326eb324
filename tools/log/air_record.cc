#include "tools/log/air_record.h"

#include <algorithm>

#include "protocol/convert.h"

namespace muster::tools {

void AirRecord::Take(const clearances_t& clearances, const Scenario& scenario) {
  if (scenario.separation() == nullptr || !Possible(clearances, scenario)) return;
  if (auto list = FromWire(clearances, WireLimits(scenario))) {
    decisions_[clearances.decision].clearances = std::move(*list);
  }
}

void AirRecord::Take(const agent_states_t& states, const Scenario& scenario) {
  const Rules& rules = scenario.rules;
  if (scenario.separation() == nullptr || states.kind != NumberOf(AgentKind::kUav) ||
      states.tick < 1 || states.tick > rules.last_tick() || scenario.uavs.size() > kMostUavs) {
    return;
  }
  const std::int32_t decision = rules.DecisionAt(states.tick - 1);
  if (decision < 0) return;
  for (const agent_t& report : states.agents) {
    const auto uav =
        FromWire(report, AgentKind::kUav, rules.TimeOf(states.tick), WireLimits(scenario));
    if (uav) decisions_[decision].uavs.try_emplace(report.id, *uav);
  }
}

std::vector<Flight> FlightsOf(const AirRecord& air, const Scenario& scenario,
                              const std::set<std::int32_t>& skipped) {
  std::map<std::int32_t, std::vector<Flight>> by_uav;
  for (const auto& [index, decision] : air.decisions()) {
    if (skipped.contains(index)) continue;
    const TimeUs from_us = scenario.rules.TimeOfDecision(index);
    for (const Clearance& clearance : decision.clearances) {
      const auto uav = decision.uavs.find(clearance.uav);
      if (clearance.decision != index || uav == decision.uavs.end()) continue;
      std::vector<Flight>& flights = by_uav[clearance.uav];
      if (!flights.empty()) flights.back().until_us = from_us;
      flights.push_back({uav->second, clearance, from_us,
                         std::min(uav->second.online_until_us, scenario.rules.limit_us)});
    }
  }
  std::vector<Flight> all;
  for (const auto& [uav, flights] : by_uav) all.insert(all.end(), flights.begin(), flights.end());
  return all;
}

AirSummary SummaryOf(const AirRecord& air, const Scenario& scenario,
                     const std::set<std::int32_t>& skipped) {
  AirSummary summary;
  const LandingPlaces landing(scenario.charging_points);
  for (const auto& [index, decision] : air.decisions()) {
    if (skipped.contains(index)) continue;
    const TimeUs at_us = scenario.rules.TimeOfDecision(index);
    std::vector<std::pair<std::int32_t, Trajectory>> paths;
    for (const Clearance& clearance : decision.clearances) {
      if (clearance.decision == index) {
        summary.altitudes_m.insert(clearance.to_m);
        summary.held += clearance.begin_us > at_us ? 1 : 0;
        summary.held_us += std::max<TimeUs>(0, clearance.begin_us - at_us);
      }
      const auto uav = decision.uavs.find(clearance.uav);
      if (uav == decision.uavs.end()) continue;
      paths.emplace_back(clearance.uav, TrajectoryOf(uav->second, clearance, at_us, landing));
    }
    for (std::size_t i = 0; i < paths.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const Separation& minima = *scenario.separation();
        if (AreFarApart(paths[i].second, paths[j].second, minima.horizontal_m)) continue;
        const auto approach = ClosestApproach(paths[i].second, paths[j].second, minima);
        if (!approach) continue;
        summary.conflicts += AreInConflict(paths[i].second, paths[j].second, minima) ? 1 : 0;
        if (summary.closest && summary.closest->approach.share <= approach->share) continue;
        summary.closest = {
            *approach, index, {paths[j].first, paths[i].first}, at_us + ToUs(approach->t_s)};
      }
    }
  }
  return summary;
}

}  // namespace muster::tools
