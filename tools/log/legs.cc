#include "tools/log/legs.h"

#include <algorithm>

#include "protocol/convert.h"

namespace muster::tools {

std::vector<Point> Leg::Line() const {
  std::vector<Point> line = {agent.from};
  for (const Ways::Corner& corner : agent.leg_ways->Corners(agent.kind, agent.from, agent.to)) {
    line.push_back(corner.at);
  }
  line.push_back(agent.to);
  return line;
}

void LegReader::Add(const agent_states_t& states, const Scenario& scenario, const Visit& visit) {
  const auto kind = static_cast<AgentKind>(states.kind);
  for (const agent_t& report : states.agents) {
    const auto now = FromWire(report, kind, states.header.sim_us, WireLimits(scenario));
    if (!now) continue;
    const auto found = under_way_.find({kind, report.id});
    if (found != under_way_.end()) {
      const AgentState& leg = found->second;
      // What is late, or told again, is of this leg or of one before.
      const bool same = now->depart_us == leg.depart_us && now->to == leg.to;
      if (now->depart_us < leg.depart_us || (same && !now->failed)) continue;
      const TimeUs ended_us = same ? states.header.sim_us : now->depart_us;
      visit({leg, std::min(leg.arrive_us, ended_us)});
      under_way_.erase(found);
      if (same) continue;
    }
    if (!now->failed && now->from != now->to) under_way_.emplace(std::pair(kind, report.id), *now);
  }
}

void LegReader::Finish(TimeUs now_us, const Visit& visit) {
  for (const auto& [id, leg] : under_way_) visit({leg, std::min(leg.arrive_us, now_us)});
  under_way_.clear();
}

}  // namespace muster::tools
