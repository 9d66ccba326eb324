#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/channels.h"
#include "tests/temporary_folder.h"
#include "tests/tools/fake_mission.h"
#include "tools/audit/audit_command.h"
#include "tools/audit/auditor.h"
#include "tools/audit/report_check.h"
#include "tools/record/report_json.h"
#include "tools/record/run_record.h"

namespace muster::tools {
namespace {

using audit::Auditor;
using audit::Violation;

std::vector<Violation> Audit(const FakeLog& log) {
  Auditor auditor;
  for (const Packet& packet : Encoded(log)) auditor.Add(packet);
  return auditor.Finish();
}

std::string Text(const std::vector<Violation>& violations) {
  std::string text;
  for (const Violation& v : violations) {
    text += std::to_string(v.at_us) + " " + v.invariant + ": " + v.text + "\n";
  }
  return text;
}

/// Edits of a valid log, each of which breaks one invariant.
struct Mutation {
  const char* name;
  const char* invariant;  ///< that the first violation must name
  std::int64_t at_us;     ///< its mission time
  const char* mentions;   ///< what its text must contain
  std::function<void(FakeLog*)> edit;
};

constexpr std::int64_t kMin = 60'000'000;

/// Reports of one agent at the ticks [first, last].
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

/// What a UAV has at the start, in the scenario and in its first report.
void SetFirstRange(FakeLog* log, int uav, double range_km) {
  EditScenario(log, [&](nlohmann::json& s) {
    s["uavs"][static_cast<std::size_t>(uav)]["range_km"] = range_km;
  });
  EditAgent(log, 0, uav, 0, 0,
            [&](agent_t& a) { a.range_left_m = a.range_at_departure_m = range_km * 1000; });
}

template <class Message>
void Remove(FakeLog* log, const std::function<bool(const Message&)>& which) {
  std::erase_if(*log, [&](const FakeMessage& m) {
    const auto* body = std::get_if<Message>(&m.body);
    return body != nullptr && which(*body);
  });
}

const std::vector<Mutation>& Mutations() {
  static const std::vector<Mutation> mutations = {
      // Sequence numbers and lockstep.
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

      // Decisions.
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

      // Agents.
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

      // Sensing, charging, tasks, events.
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
  return mutations;
}

TEST(Audit, PassesAValidLog) {
  for (const std::int64_t tick_us : {10'000'000, 60'000'000, 200'000'000, 600'000'000}) {
    EXPECT_EQ(Text(Audit(MakeFakeMission(tick_us))), "") << tick_us;
  }
}

TEST(Audit, PassesWhenMessagesComeTwiceOrLate) {
  const std::vector<Packet> packets = Encoded(MakeFakeMission());
  std::vector<Packet> stirred;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const std::size_t block = i / 24 * 24;  // each block of three ticks or so backwards
    const std::size_t n = std::min<std::size_t>(24, packets.size() - block);
    stirred.push_back(packets[block + n - 1 - (i - block)]);
    if (i % 5 == 0) stirred.push_back(packets[i]);
  }
  Auditor auditor;
  for (const Packet& packet : stirred) auditor.Add(packet);
  EXPECT_EQ(Text(auditor.Finish()), "");
  EXPECT_GT(auditor.duplicates(), 0);
  EXPECT_EQ(auditor.messages(), static_cast<std::int64_t>(packets.size()));
}

TEST(Audit, CatchesEveryMutation) {
  for (const Mutation& mutation : Mutations()) {
    FakeLog log = MakeFakeMission();
    mutation.edit(&log);
    const std::vector<Violation> violations = Audit(log);
    ASSERT_FALSE(violations.empty()) << mutation.name;
    const Violation& first = violations[0];
    EXPECT_EQ(first.invariant, mutation.invariant) << mutation.name << "\n" << Text(violations);
    EXPECT_EQ(first.at_us, mutation.at_us) << mutation.name << "\n" << Text(violations);
    EXPECT_NE(first.text.find(mutation.mentions), std::string::npos) << mutation.name << "\n"
                                                                     << Text(violations);
  }
}

/// Rules that need a mission which this one is not; the tests that break them.
const std::map<std::string, const char*> kBrokenElsewhere = {
    {"meeting", "AuditMission.CatchesAMeetingThatLastsTooShort"},
    {"report", "Audit.ComparesTheReportWithTheLog"}};

TEST(Audit, EveryRuleOfTheDocumentIsBrokenBySomeMutation) {
  std::ifstream document(MUSTER_SOURCE_DIR "/docs/audit.md");
  ASSERT_TRUE(document);
  std::set<std::string> rules;
  for (std::string line; std::getline(document, line);) {
    // "| `sensing`, `charging` | begin when ..."
    if (line.rfind("| `", 0) != 0) continue;
    const std::string names = line.substr(0, line.find(" |", 2));
    for (std::size_t begin = names.find('`'); begin != std::string::npos;) {
      const std::size_t end = names.find('`', begin + 1);
      rules.insert(names.substr(begin + 1, end - begin - 1));
      begin = names.find('`', end + 1);
    }
  }
  std::set<std::string> broken;
  for (const Mutation& mutation : Mutations()) broken.insert(mutation.invariant);
  for (const auto& [rule, test] : kBrokenElsewhere) {
    EXPECT_FALSE(broken.contains(rule)) << rule;
    broken.insert(rule);
  }
  EXPECT_EQ(rules, broken);
}

class AuditCommandTest : public testing::Test {
 protected:
  int Run(const FakeLog& log, std::vector<const char*> more = {}) {
    std::filesystem::remove(file_);
    {
      EventLogWriter writer(file_);
      for (const Packet& packet : Encoded(log)) writer.Write(1, packet);
      writer.Flush();
    }
    std::vector<const char*> arguments = {"muster audit", file_.c_str()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    testing::internal::CaptureStdout();
    const int code = AuditCommand(static_cast<int>(arguments.size()), arguments.data());
    std::fflush(stdout);
    out_ = testing::internal::GetCapturedStdout();
    return code;
  }
  const TemporaryFolder folder_;
  const std::string file_ = folder_.File("mission.lcm");
  std::string out_;
};

TEST_F(AuditCommandTest, PrintsTheFirstViolationAndExitsWithFour) {
  EXPECT_EQ(Run(MakeFakeMission()), 0);
  EXPECT_NE(out_.find("passed: every rule holds"), std::string::npos) << out_;
  FakeLog log = MakeFakeMission();
  EditAgent(&log, 1, 0, 2, 2, [](agent_t& a) { a.x_m += 500; });
  EXPECT_EQ(Run(log), 4);
  EXPECT_NE(out_.find("  00:02:00.000000  speed: worker:0 moved "), std::string::npos) << out_;
  EXPECT_EQ(Run(log, {"--json"}), 4);
  const auto json = nlohmann::json::parse(out_);
  EXPECT_FALSE(json["passed"].get<bool>());
  EXPECT_EQ(json["violations"][0]["at_us"], 2 * kMin);
  EXPECT_EQ(json["violations"][0]["invariant"], "speed");
}

TEST(Audit, AnEmptyLogFails) {
  Auditor auditor;
  const auto& violations = auditor.Finish();
  ASSERT_EQ(violations.size(), 1u);
  EXPECT_EQ(violations[0].invariant, "scenario");
}

TEST(Audit, ComparesTheReportWithTheLog) {
  const FakeLog log = MakeFakeMission();
  Auditor auditor;
  RunRecord record;
  for (const Packet& packet : Encoded(log)) {
    auditor.Add(packet);
    record.Add(packet);
  }
  ASSERT_EQ(Text(auditor.Finish()), "");
  ASSERT_TRUE(auditor.facts());
  const nlohmann::json report = nlohmann::json::parse(Report(record).dump());
  EXPECT_EQ(Text(audit::CheckReportFile(report, *auditor.facts())), "");

  const std::pair<const char*, nlohmann::json> edits[] = {
      {"/tasks_done", 1},
      {"/tasks_total", 3},
      {"/completion_rate", 0.5},
      {"/charges", 2},
      {"/seed", 6},
      {"/flown_m", 14545},
      {"/digest", std::string(64, '0')},
      {"/events/sensing_done", 3},
      {"/tasks/0/uav", 1},
      {"/tasks/1/done_s", 961},
      {"/uavs/1/range_left_m", 18455},
      {"/log/messages", 1},
      {"/log/complete", false},
      {"/decisions/1/weight", 3.374},
      {"/decisions/1/bound", 4},
      {"/decisions/2/bound", nullptr},
      {"/decisions/0/actions/3/worker", 1},
      {"/decisions/0/actions/1/weight", 0.3},  // the log says 0.1 + 0.2
      {"/decisions", nlohmann::json::array()},
  };
  for (const auto& [pointer, value] : edits) {
    nlohmann::json edited = report;
    ASSERT_NE(edited.at(nlohmann::json::json_pointer(pointer)), value) << pointer;
    edited[nlohmann::json::json_pointer(pointer)] = value;
    const auto violations = audit::CheckReportFile(edited, *auditor.facts());
    ASSERT_EQ(violations.size(), 1u) << pointer << "\n" << Text(violations);
    EXPECT_EQ(violations[0].invariant, "report");
    EXPECT_NE(violations[0].text.find(std::string(pointer).substr(1)), std::string::npos)
        << Text(violations);
  }
}

}  // namespace
}  // namespace muster::tools
