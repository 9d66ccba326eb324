#include "tests/tools/audit/mutations.h"

namespace muster::tools {

std::vector<Mutation> LockstepMutations() {
  return {
      {"a message is missing", "seq", 30 * kMin, "uav (start 0) lacks seq 32",
       [](FakeLog* log) {
         Remove<process_status_t>(
             log, [](const process_status_t& s) { return s.name == "uav" && s.state == 4; });
         FakeMessage late = log->back();
         auto& status = std::get<process_status_t>(late.body);
         status.name = status.header.sender = "uav";
         status.header.seq = 33;
         log->push_back(late);
       }},
      {"one seq, two contents", "seq", 12 * kMin, "two different messages",
       [](FakeLog* log) {
         for (const FakeMessage& m : FakeLog(*log)) {
           const auto* s = std::get_if<agent_states_t>(&m.body);
           if (s == nullptr || s->tick != 12 || s->kind != 1) continue;
           log->push_back(m);
           std::get<agent_states_t>(log->back().body).agents[0].x_m += 1;
         }
       }},
      {"an agent's report is missing", "lockstep", 7 * kMin, "state of worker:1",
       [](FakeLog* log) {
         ForEach<agent_states_t>(log, [](agent_states_t& s) {
           if (s.kind != 1 || s.tick != 7) return;
           s.agents.pop_back();
           --s.n;
         });
       }},
      {"an agent reports twice", "lockstep", 7 * kMin, "uav:0 is reported twice for tick 7",
       [](FakeLog* log) {
         for (const FakeMessage& m : FakeLog(*log)) {
           const auto* s = std::get_if<agent_states_t>(&m.body);
           if (s == nullptr || s->tick != 7 || s->kind != 0) continue;
           log->insert(std::find_if(log->begin(), log->end(),
                                    [](const FakeMessage& other) {
                                      const auto* w = std::get_if<world_state_t>(&other.body);
                                      return w != nullptr && w->tick == 7;
                                    }),
                       m);
           break;
         }
         Renumber(log);
       }},
      {"a world state is missing", "lockstep", 9 * kMin, "world_state_t",
       [](FakeLog* log) {
         Remove<world_state_t>(log, [](const world_state_t& w) { return w.tick == 9; });
         Renumber(log);
       }},
      {"a decision is missing", "lockstep", 10 * kMin, "schedule_t of decision 1",
       [](FakeLog* log) {
         Remove<schedule_t>(log, [](const schedule_t& s) { return s.decision == 1; });
         Renumber(log);
       }},
      {"a decision is passed over", "lockstep", 10 * kMin,
       "the clock does not require decision 1, and nobody was lost",
       [](FakeLog* log) {
         ForEach<clock_t>(log, [](clock_t& c) {
           if (c.tick > 10 && c.required_decision == 1) c.required_decision = 0;
         });
       }},
      {"a decision is made again, differently", "lockstep", 10 * kMin, "twice and differently",
       [](FakeLog* log) {
         for (const FakeMessage& m : FakeLog(*log)) {
           const auto* s = std::get_if<schedule_t>(&m.body);
           if (s == nullptr || s->decision != 1) continue;
           log->push_back(m);
           auto& again = std::get<schedule_t>(log->back().body);
           again.header.boot_id = 1;
           again.actions.pop_back();
           --again.n;
         }
         Renumber(log);
       }},
      {"the end is missing", "lockstep", 30 * kMin, "phase 2",
       [](FakeLog* log) {
         Remove<clock_t>(log, [](const clock_t& c) { return c.phase == 2; });
         Renumber(log);
       }},
      {"the clock skips", "clock", 5 * kMin, "tick_us",
       [](FakeLog* log) {
         ForEach<clock_t>(log, [](clock_t& c) {
           if (c.tick == 5) c.tick_us += 1;
         });
       }},
      {"an agent did not apply the decision", "lockstep", 11 * kMin, "applied decision 0",
       [](FakeLog* log) {
         ForEach<agent_states_t>(log, [](agent_states_t& s) {
           if (s.tick == 11 && s.kind == 2) s.applied_decision = 0;
         });
       }},
      {"the scenario is not the one announced", "scenario", 0, "sha256",
       [](FakeLog* log) { ForEach<scenario_t>(log, [](scenario_t& s) { s.json += " "; }); }},

  };
}

}  // namespace muster::tools
