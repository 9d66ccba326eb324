#include <nlohmann/json.hpp>

#include "tests/tools/audit/mutations.h"

namespace muster::tools {

std::vector<Mutation> AgentMutations() {
  return {
      {"an agent is faster than its speed", "speed", 2 * kMin, "worker:0 moved",
       [](FakeLog* log) { EditAgent(log, 1, 0, 2, 2, [](agent_t& a) { a.x_m += 500; }); }},
      {"an agent arrives too early", "speed", kMin, "reports a way",
       [](FakeLog* log) {
         EditAgent(log, 2, 0, 1, 3, [](agent_t& a) {
           a.arrive_us -= 100;
           a.busy_until_us = a.arrive_us;
         });
       }},
      {"an agent has another speed than the scenario says", "scenario", 3 * kMin, "speed_m_s",
       [](FakeLog* log) { EditAgent(log, 0, 1, 3, 3, [](agent_t& a) { a.speed_m_s *= 1.001; }); }},
      {"an agent strays", "motion", 2 * kMin, "its way leads it to",
       [](FakeLog* log) { EditAgent(log, 1, 0, 2, 2, [](agent_t& a) { a.x_m -= 1; }); }},
      {"an agent ignores its command", "obedience", kMin, "vehicle:0 did not begin",
       [](FakeLog* log) {
         EditAgent(log, 2, 0, 1, 30, [](agent_t& a) {
           a.action = -1;
           a.x_m = 8000;
         });
       }},
      {"a UAV has more range than it can hold", "range", 2 * kMin, "40000",
       [](FakeLog* log) {
         EditAgent(log, 0, 0, 2, 2, [](agent_t& a) { a.range_left_m = 40000; });
       }},
      {"range falls below zero", "lockstep", 2 * kMin, "state of uav:0",  // no valid message
       [](FakeLog* log) { EditAgent(log, 0, 0, 2, 2, [](agent_t& a) { a.range_left_m = -1; }); }},
      {"range does not fall on the way", "range", 2 * kMin, "uav:0",
       [](FakeLog* log) { EditAgent(log, 0, 0, 2, 2, [](agent_t& a) { a.range_left_m += 5; }); }},
      {"a UAV flies on with no range left", "range", 3 * kMin, "further than its range",
       [](FakeLog* log) {
         // The first command and its reports, for a UAV that has 2.5 km of range: constraint (6)
         // would break first, so a communication cost takes the range away after the decision.
         EditScenario(log, [](nlohmann::json& s) {
           s["disturbances"] = {{"communication_km", {27.5, 27.5}}};
         });
         EditAgent(log, 0, 0, 1, 30, [](agent_t& a) {
           a.range_at_departure_m -= 27500;
           a.range_left_m = std::max(0.0, a.range_left_m - 27500);
         });
         EditAgent(log, 0, 1, 1, 30, [](agent_t& a) {
           a.range_at_departure_m -= 27500;
           a.range_left_m = std::max(0.0, a.range_left_m - 27500);
         });
         EditActivity(log, 0, 0, [](activity_t& a) { a.start_us = a.end_us = INT64_MAX; });
         EditAgent(log, 0, 0, 2, 30, [](agent_t& a) { a.busy_until_us = INT64_MAX; });
         EditAgent(log, 1, 0, 2, 30, [](agent_t& a) { a.busy_until_us = INT64_MAX; });
       }},

  };
}

}  // namespace muster::tools
