#include <nlohmann/json.hpp>

#include "lcmtypes/channels.h"
#include "tests/tools/audit/mutations.h"

namespace muster::tools {

std::vector<Mutation> DecisionMutations() {
  return {
      {"an agent gets two actions", "one-action-per-agent", 0, "uav:1",
       [](FakeLog* log) {
         EditDecision(log, 0, [](schedule_t& s) {
           action_t stay = s.actions[0];
           stay.kind = 0;
           stay.uav_id = 1;
           stay.worker_id = -1;
           stay.x_m = 9000;
           stay.y_m = 8000;
           s.actions.push_back(stay);
         });
       }},
      {"a busy agent is commanded", "idle-agents-only", 10 * kMin,
       "uav:0 is sensing, busy until 612666153 us",
       [](FakeLog* log) { *log = MakeFakeMission(kMin, 3000); }},
      {"an offline agent is commanded", "idle-agents-only", 10 * kMin, "uav:1 is offline",
       [](FakeLog* log) {
         EditScenario(log, [](nlohmann::json& s) { s["uavs"][1]["online_until_min"] = 10; });
         EditAgent(log, 0, 1, 0, 30, [](agent_t& a) { a.online_until_us = 10 * kMin; });
         EditAgent(log, 0, 1, 10, 30, [](agent_t& a) {
           if (a.status == 1) a.status = 0;
         });
         FakeMessage message = *std::find_if(log->begin(), log->end(), [](const FakeMessage& m) {
           return m.channel == channel::kEvent;
         });
         auto& event = std::get<event_t>(message.body);
         event.kind = 1;
         event.at_us = 10 * kMin;
         event.uav_id = 1;
         log->push_back(message);
         Renumber(log);
       }},
      {"a command has the ids of another kind", "decision", 0, "has not the ids of its kind",
       [](FakeLog* log) {
         EditDecision(log, 0, [](schedule_t& s) { s.actions[1].worker_id = 1; });
       }},
      {"a command names an unknown task", "decision", 0, "does not have",
       [](FakeLog* log) { EditDecision(log, 0, [](schedule_t& s) { s.actions[1].task_id = 2; }); }},
      {"a command leads elsewhere", "decision", 0, "leads to",
       [](FakeLog* log) { EditDecision(log, 0, [](schedule_t& s) { s.actions[3].x_m += 1; }); }},
      {"a task is given twice", "task-open", 0, "in action 1 too",
       [](FakeLog* log) {
         EditDecision(log, 0, [](schedule_t& s) {
           s.actions[3].task_id = 1;
           s.actions[3].x_m = s.actions[3].y_m = 9000;
         });
       }},
      {"a pair is sent that comes after the task has expired", "expiry", 0,
       "there at 432666153 us, the task expires at 420000000 us",
       [](FakeLog* log) {
         EditScenario(log, [](nlohmann::json& s) {
           s["version"] = 2;
           s["tasks"][0]["expires_min"] = 7;
         });
       }},
      {"a task is given before it is reported", "task-status", 0,
       "task:1 is said to be open, it is unreported",
       [](FakeLog* log) {
         EditScenario(log, [](nlohmann::json& s) {
           s["version"] = 2;
           s["tasks"][1]["reported_min"] = 5;
         });
       }},
      {"a done task is given", "task-open", 20 * kMin, "the task is done",
       [](FakeLog* log) {
         EditDecision(log, 2, [](schedule_t& s) {
           s.actions[1].kind = 3;
           s.actions[1].task_id = 1;
           s.actions[1].charge_id = -1;
           s.actions[1].x_m = s.actions[1].y_m = 9000;
         });
       }},
      {"a charging point is overfilled", "capacity", 10 * kMin, "capacity 1",
       [](FakeLog* log) {
         EditDecision(log, 1, [](schedule_t& s) {
           action_t go = s.actions[1];
           go.kind = 5;
           go.uav_id = 1;
           go.vehicle_id = -1;
           s.actions[0] = go;
         });
       }},
      {"range does not reach the charging point", "constraint-5", 0,
       "7615.773 m of way, 5000.000 m of range",
       [](FakeLog* log) {
         SetFirstRange(log, 1, 5);
         EditDecision(log, 0, [](schedule_t& s) {
           action_t& charge = s.actions[1];
           charge.kind = 5;
           charge.task_id = -1;
           charge.charge_id = 0;
           charge.x_m = 6000;
           charge.y_m = 1000;
           s.actions.erase(s.actions.begin() + 2);
         });
       }},
      {"range does not suffice to sense and charge", "constraint-6", 0,
       "1000.000 m of way, 2000.000 m to sense, 8544.004 m to the nearest",
       [](FakeLog* log) { SetFirstRange(log, 1, 11.5); }},
      {"a pair's range does not suffice", "constraint-6", 0, "UiTxWj uav:0 worker:0 task:0",
       [](FakeLog* log) { SetFirstRange(log, 0, 6.9); }},
      {"an action ends after an agent's downtime", "availability", 10 * kMin, "must be free",
       [](FakeLog* log) {
         EditScenario(log, [](nlohmann::json& s) { s["workers"][1]["online_until_min"] = 15.5; });
         EditAgent(log, 1, 1, 0, 30, [](agent_t& a) { a.online_until_us = 15 * kMin + kMin / 2; });
       }},
      {"a decision's weight is not its actions'", "weight", 10 * kMin, "decision 1",
       [](FakeLog* log) {
         ForEach<schedule_t>(log, [](schedule_t& s) {
           if (s.decision == 1) s.weight += 1e-3;
         });
       }},
      {"a decision weighs more than its bound", "weight", 20 * kMin, "bound",
       [](FakeLog* log) {
         ForEach<schedule_t>(log, [](schedule_t& s) {
           if (s.decision == 2) s.bound = 1.4;
         });
       }},

  };
}

}  // namespace muster::tools
