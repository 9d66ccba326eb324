#include <nlohmann/json.hpp>

#include "tests/tools/audit/mutations.h"

namespace muster::tools {

std::vector<Mutation> OutcomeMutations() {
  return {
      {"sensing starts before a partner is there", "sensing", kMin, "worker:0 at 432666",
       [](FakeLog* log) { EditActivity(log, 0, 0, [](activity_t& a) { a.start_us = 3 * kMin; }); }},
      {"sensing is cut short", "sensing", 11 * kMin, "ends at",
       [](FakeLog* log) { EditActivity(log, 0, 1, [](activity_t& a) { a.end_us -= 1000; }); }},
      {"a partner leaves while sensing", "motion", 8 * kMin, "worker:0",
       [](FakeLog* log) { EditAgent(log, 1, 0, 8, 8, [](agent_t& a) { a.x_m += 100; }); }},
      {"sensing without a command", "sensing", 11 * kMin, "no decision in force commands it",
       [](FakeLog* log) { EditActivity(log, 0, 1, [](activity_t& a) { a.partner_id = 0; }); }},
      {"charging is cut short", "charging", 11 * kMin, "ends at",
       [](FakeLog* log) { EditActivity(log, 1, 0, [](activity_t& a) { a.end_us -= 1000; }); }},
      {"charging starts before the UAV is there", "charging", 11 * kMin, "uav:0 arrives at",
       [](FakeLog* log) {
         EditActivity(log, 1, 0, [](activity_t& a) {
           a.start_us -= kMin;
           a.end_us -= kMin;
         });
       }},
      {"an activity changes while under way", "activities", 14 * kMin, "changed",
       [](FakeLog* log) {
         ForEach<world_state_t>(log, [](world_state_t& w) {
           if (w.tick < 14 || w.activities.empty()) return;
           w.activities.back().end_us += 1;
         });
       }},
      {"a commanded pair does nothing", "activities", 11 * kMin, "neither an activity nor",
       [](FakeLog* log) {
         ForEach<world_state_t>(log, [](world_state_t& w) {
           std::erase_if(w.activities, [](const activity_t& a) { return a.uav_id == 1; });
           w.n_activities = static_cast<std::int32_t>(w.activities.size());
         });
       }},
      {"a task is done twice", "task-twice", 11 * kMin, "at task:0",
       [](FakeLog* log) { EditActivity(log, 0, 1, [](activity_t& a) { a.site_id = 0; }); }},
      {"a task is said to be done too early", "task-status", 9 * kMin, "task:0 is said to be done",
       [](FakeLog* log) {
         ForEach<world_state_t>(log, [](world_state_t& w) {
           if (w.tick != 9) return;
           w.task_status[0] = 3;
           w.done = 1;
         });
       }},
      {"the number of tasks done is wrong", "task-status", 22 * kMin, "1 tasks are said",
       [](FakeLog* log) {
         ForEach<world_state_t>(log, [](world_state_t& w) {
           if (w.tick == 22) w.done = 1;
         });
       }},
      {"an event is missing", "events", 16 * kMin, "not said: sensing done uav:1",
       [](FakeLog* log) {
         Remove<event_t>(log, [](const event_t& e) { return e.kind == 5 && e.uav_id == 1; });
         Renumber(log);
       }},
      {"an event has another time", "events", 12 * kMin - 5, "charging started",
       [](FakeLog* log) { EditEvents(log, 7, [](event_t& e) { e.at_us -= 5; }); }},
      {"an event is invented", "events", 22 * kMin, "said but not so: agent failed worker:1",
       [](FakeLog* log) {
         FakeMessage message = *std::find_if(log->begin(), log->end(), [](const FakeMessage& m) {
           const auto* e = std::get_if<event_t>(&m.body);
           return e != nullptr && e->worker_id == 1;
         });
         auto& event = std::get<event_t>(message.body);
         event.kind = 2;
         event.at_us = 22 * kMin;
         log->push_back(message);
         Renumber(log);
       }},
      {"a task is given while it is being sensed", "task-open", 10 * kMin,
       "the task is being sensed",
       [](FakeLog* log) {
         *log = MakeFakeMission(kMin, 3000);
         EditDecision(log, 1, [](schedule_t& s) { s.actions[0].task_id = 0; });
       }},
      {"a message is said again with another content", "seq", 5 * kMin, "two different messages",
       [](FakeLog* log) {
         for (const FakeMessage& m : FakeLog(*log)) {
           const auto* w = std::get_if<world_state_t>(&m.body);
           if (w == nullptr || w->tick != 5) continue;
           log->push_back(m);
           std::get<world_state_t>(log->back().body).done = 2;
         }
       }},
      {"a vehicle gets two actions", "one-action-per-agent", 10 * kMin, "vehicle:0",
       [](FakeLog* log) {
         EditDecision(log, 1, [](schedule_t& s) {
           action_t go = s.actions[1];
           go.kind = 6;
           go.uav_id = -1;
           s.actions.insert(s.actions.begin(), go);
         });
       }},
      {"a charging pair's range does not suffice", "constraint-5", 10 * kMin,
       "UiCyVk uav:0 vehicle:0 charge:0",
       [](FakeLog* log) {
         // The UAV has 25 km left at 10 min; with 23.5 km less at the start 1.5 km, and 2 km to go.
         SetFirstRange(log, 0, 6.5);
         EditAgent(log, 0, 0, 1, 10, [](agent_t& a) {
           a.range_left_m -= 23500;
           a.range_at_departure_m -= 23500;
         });
         // Without the task's own need of range to charge.
         EditScenario(log, [](nlohmann::json& s) {
           s["charging_points"].push_back({{"id", 1}, {"x_km", 4}, {"y_km", 1}});
         });
       }},
      {"an agent fails and nobody is told", "rulings", 7 * kMin, "released",
       [](FakeLog* log) {
         ForEach<rulings_t>(log, [](rulings_t& r) {
           if (r.tick != 7) return;
           r.rulings.push_back({0, 0, 1, 7 * kMin});
           r.n = 1;
         });
       }},
  };
}

}  // namespace muster::tools
