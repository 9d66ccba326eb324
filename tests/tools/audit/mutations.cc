#include "tests/tools/audit/mutations.h"

#include <nlohmann/json.hpp>

#include "tools/audit/audit_scenario.h"

namespace muster::tools {

std::vector<Mutation> Mutations() {
  std::vector<Mutation> all;
  for (const auto& some :
       {LockstepMutations(), DecisionMutations(), AgentMutations(), OutcomeMutations()}) {
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

void EditAgent(FakeLog* log, int kind, int id, std::int64_t first, std::int64_t last,
               const std::function<void(agent_t&)>& edit) {
  ForEach<agent_states_t>(log, [&](agent_states_t& s) {
    if (s.kind != kind || s.tick < first || s.tick > last) return;
    for (agent_t& agent : s.agents) {
      if (agent.id == id) edit(agent);
    }
  });
}

void EditDecision(FakeLog* log, int decision, const std::function<void(schedule_t&)>& edit) {
  ForEach<schedule_t>(log, [&](schedule_t& s) {
    if (s.decision == decision) edit(s);
    s.n = static_cast<std::int32_t>(s.actions.size());
    s.weight = 0;
    for (const action_t& a : s.actions) s.weight += a.weight;
  });
}

void EditActivity(FakeLog* log, int kind, int uav, const std::function<void(activity_t&)>& edit) {
  ForEach<world_state_t>(log, [&](world_state_t& w) {
    for (activity_t& a : w.activities) {
      if (a.kind == kind && a.uav_id == uav) edit(a);
    }
  });
}

void EditEvents(FakeLog* log, int kind, const std::function<void(event_t&)>& edit) {
  ForEach<event_t>(log, [&](event_t& e) {
    if (e.kind == kind) edit(e);
  });
}

void EditScenario(FakeLog* log, const std::function<void(nlohmann::json&)>& edit) {
  ForEach<scenario_t>(log, [&](scenario_t& s) {
    nlohmann::json json = nlohmann::json::parse(s.json);
    edit(json);
    s.json = json.dump();
    s.sha256 = audit::Sha256Of(s.json);
  });
}

void SetFirstRange(FakeLog* log, int uav, double range_km) {
  EditScenario(log, [&](nlohmann::json& s) {
    s["uavs"][static_cast<std::size_t>(uav)]["range_km"] = range_km;
  });
  EditAgent(log, 0, uav, 0, 0,
            [&](agent_t& a) { a.range_left_m = a.range_at_departure_m = range_km * 1000; });
}

}  // namespace muster::tools
