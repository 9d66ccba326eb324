// The audit on whole simulated missions: what the mission's own code does must pass, under every
// disturbance and rule.
#include <gtest/gtest.h>

#include <optional>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/order.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tools/audit/auditor.h"
#include "tools/audit/report_check.h"
#include "tools/record/report_json.h"
#include "tools/record/run_record.h"

namespace muster::tools {
namespace {

struct Case {
  std::string name;
  std::string policy = "mpq";
  std::function<void(GeneratorSettings*)> change = [](GeneratorSettings*) {};
};

/// What the processes of a mission say.
std::vector<Packet> PacketsOf(const Scenario& scenario, const std::string& policy) {
  std::vector<Packet> packets;
  Simulate(ScenarioToJson(scenario), policy,
           [&](const Packet& packet) { packets.push_back(packet); });
  return packets;
}

std::vector<Case> MutationCases() {
  const auto storm = [](GeneratorSettings* s) {
    s->disturbances = {{0.1, 0.4}, {100, 500}, {0.01, 0.05}, {0.05, 0.1}};
  };
  return {
      {"calm"},
      {"wind", "mpq",
       [](GeneratorSettings* s) {
         s->disturbances.wind = {0.1, 0.4};
       }},
      {"communication", "mpq",
       [](GeneratorSettings* s) {
         s->disturbances.communication_m = {100, 500};
       }},
      {"agent failures", "mpq",
       [](GeneratorSettings* s) {
         s->disturbances.agent_failure = {0.01, 0.05};
       }},
      {"match failures", "mpq",
       [](GeneratorSettings* s) {
         s->disturbances.match_failure = {0.05, 0.1};
       }},
      {"everything, little range", "mpq",
       [=](GeneratorSettings* s) {
         storm(s);
         s->disturbances.wind = {0.3, 0.9};
         s->disturbances.communication_m = {100, 3000};
         s->full_range_km = 10;
         s->start_fraction = {0.3, 1};
       }},
      {"overrun, any metre", "mpq",
       [=](GeneratorSettings* s) {
         storm(s);
         s->rules.availability = Availability::kOverrun;
         s->placement = Placement::kContinuous;
         s->online_min = {20, 90};
       }},
      {"one tick a decision", "mpq",
       [=](GeneratorSettings* s) {
         storm(s);
         s->rules.tick_us = s->rules.interval_us;
       }},
      {"a limit between ticks", "mpq",
       [=](GeneratorSettings* s) {
         storm(s);
         s->rules.interval_us = 5 * kMinuteUs;
         s->rules.tick_us = 75 * kSecondUs;
         s->rules.limit_us = 62 * kMinuteUs;
       }},
      {"meetings", "greedy-nearest",
       [](GeneratorSettings* s) {
         s->rules.start_on_meeting = true;
         s->disturbances.wind = {0.1, 0.4};
       }},
      {"three at a charging point", "kwta", [](GeneratorSettings* s) { s->capacity = 3; }},
  };
}

TEST(AuditMission, PassesWhateverHappens) {
  for (const Case& c : MutationCases()) {
    for (const std::uint64_t seed : {1, 2}) {
      GeneratorSettings settings = PresetByName("Random_1");
      settings.rules.limit_us = 90 * kMinuteUs;
      c.change(&settings);
      audit::Auditor auditor;
      RunRecord record;
      Simulate(ScenarioToJson(Generate(settings, seed)), c.policy, [&](const Packet& packet) {
        auditor.Add(packet);
        record.Add(packet);
      });
      for (const audit::Violation& v : auditor.Finish()) {
        ADD_FAILURE() << c.name << ", seed " << seed << ": " << v.at_us << " us, " << v.invariant
                      << ": " << v.text;
      }
      EXPECT_GT(auditor.activities(), 0) << c.name;
      ASSERT_TRUE(auditor.facts()) << c.name;
      const auto report = nlohmann::json::parse(Report(record).dump());
      for (const audit::Violation& v : audit::CheckReportFile(report, *auditor.facts())) {
        ADD_FAILURE() << c.name << ", seed " << seed << ": " << v.text;
      }
    }
  }
}

// Zones that lie evenly between places on a grid: two ways out, and two around, are equally long.
TEST(AuditMission, PassesWhereFlightsAroundZonesAreEquallyLong) {
  for (const std::uint64_t seed : {6, 7, 8}) {
    GeneratorSettings settings = PresetByName("Random_1");
    settings.rules.limit_us = 60 * kMinuteUs;
    settings.width_km = settings.height_km = 8;
    settings.online_min = {60, 60};
    auto scenario = nlohmann::json::parse(ScenarioToJson(Generate(settings, seed)));
    scenario["version"] = 2;
    scenario["air"] = {{"separation", false},
                       {"zones",
                        {{{"name", "round"}, {"circle_km", {4, 4, 1.2}}},
                         {{"name", "square"}, {"area_km", {{1, 5}, {3, 5}, {3, 7}, {1, 7}}}}}}};
    audit::Auditor auditor;
    Simulate(scenario.dump(), "horizon-steps", [&](const Packet& packet) { auditor.Add(packet); });
    for (const audit::Violation& v : auditor.Finish()) {
      ADD_FAILURE() << "seed " << seed << ": " << v.at_us << " us, " << v.invariant << ": "
                    << v.text;
    }
    EXPECT_GT(auditor.activities(), 20) << seed;
  }
}

// Once it has stopped, the audit does not know which decisions were asked for later.
TEST(AuditMission, SaysNothingOfDecisionsThatAreAskedForAfterItHasStopped) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.rules.limit_us = 60 * kMinuteUs;
  Scenario scenario = Generate(settings, 1);
  AddRoom({5, {4, 4, 4}}, &scenario);
  const char* const json = R"({"id": "now", "at_min": 42, "order": "decide_now"})";
  audit::Auditor auditor;
  Simulate(ScenarioToJson(scenario), "horizon",
           [&](Packet packet) {
             // From 30 min on nobody is said to sense anything.
             if (packet.channel == channel::kWorld) {
               world_state_t world = *Decode<world_state_t>(packet.bytes);
               if (world.header.sim_us >= 30 * kMinuteUs) {
                 world.activities.clear();
                 world.n_activities = 0;
               }
               packet = {packet.channel, Encode(world)};
             }
             auditor.Add(packet);
           },
           {}, {{ParseOrder(json, "order"), json}});
  const auto violations = auditor.Finish();
  EXPECT_FALSE(violations.empty());
  for (const audit::Violation& v : violations) {
    EXPECT_LT(v.at_us, 42 * kMinuteUs) << v.invariant << ": " << v.text;
  }
}

/// Every edit of one field of one message of a real mission that changes what it says is caught:
/// the audit leaves nothing that an outcome rests on unlooked at.
template <class Message>
void ExpectCaught(const std::vector<Packet>& packets, std::string_view channel, const char* what,
                  const std::function<bool(Message&)>& edit) {
  int edited = 0;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    if (packets[i].channel != channel) continue;
    Message message = *Decode<Message>(packets[i].bytes);
    if (!edit(message)) continue;
    if (++edited % 7 != 1) continue;  // a sample: each is a whole audit
    audit::Auditor auditor;
    for (std::size_t j = 0; j < packets.size(); ++j) {
      auditor.Add(j == i ? Packet{packets[j].channel, Encode(message)} : packets[j]);
    }
    EXPECT_FALSE(auditor.Finish().empty()) << what << ", packet " << i;
  }
  EXPECT_GT(edited, 0) << what;
}

TEST(AuditMission, CatchesAnEditOfAnyFieldThatMatters) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.rules.limit_us = 40 * kMinuteUs;
  settings.rules.tick_us = 2 * kMinuteUs;
  settings.disturbances.wind = {0.1, 0.4};
  settings.disturbances.agent_failure = {0.02, 0.1};
  std::vector<Packet> packets = PacketsOf(Generate(settings, 3), "mpq");

  const auto busy = [](agent_states_t& s) -> agent_t* {
    for (agent_t& a : s.agents) {
      if (a.action >= 7) return &a;
    }
    return nullptr;
  };
  const auto agent_edit = [&](const char* what, std::string_view channel,
                              const std::function<void(agent_t&)>& edit) {
    ExpectCaught<agent_states_t>(packets, channel, what, [&](agent_states_t& s) {
      agent_t* agent = busy(s);
      if (agent != nullptr) edit(*agent);
      return agent != nullptr;
    });
  };
  agent_edit("x", channel::kUavs, [](agent_t& a) { a.x_m += 0.1; });
  agent_edit("y", channel::kWorkers, [](agent_t& a) { a.y_m -= 0.1; });
  agent_edit("speed", channel::kVehicles, [](agent_t& a) { a.speed_m_s *= 1.01; });
  agent_edit("range", channel::kUavs, [](agent_t& a) { a.range_left_m += 1; });
  agent_edit("departure", channel::kUavs, [](agent_t& a) { a.depart_us += 10; });
  agent_edit("arrival", channel::kWorkers, [](agent_t& a) { a.arrive_us += 10; });
  agent_edit("status", channel::kWorkers, [](agent_t& a) { a.status = a.status == 4 ? 3 : 4; });
  agent_edit("partner", channel::kUavs, [](agent_t& a) { ++a.partner_id; });
  agent_edit("target", channel::kVehicles, [](agent_t& a) { ++a.target_id; });
  agent_edit("free too early", channel::kUavs, [](agent_t& a) { a.busy_until_us = 0; });

  const auto activity_edit = [&](const char* what, const std::function<void(activity_t&)>& edit) {
    ExpectCaught<world_state_t>(packets, channel::kWorld, what, [&](world_state_t& w) {
      if (w.activities.empty()) return false;
      edit(w.activities.back());
      return true;
    });
  };
  activity_edit("start", [](activity_t& a) { a.start_us -= a.start_us < INT64_MAX ? 10 : 0; });
  activity_edit("end", [](activity_t& a) { a.end_us -= 10; });
  activity_edit("pair", [](activity_t& a) { a.partner_id = a.partner_id == 0 ? 1 : 0; });
  ExpectCaught<world_state_t>(packets, channel::kWorld, "activity gone", [](world_state_t& w) {
    if (w.activities.empty()) return false;
    w.activities.pop_back();
    --w.n_activities;
    return true;
  });
  ExpectCaught<world_state_t>(packets, channel::kWorld, "task status", [](world_state_t& w) {
    if (w.task_status[0] == 3) return false;
    w.task_status[0] = 3;
    ++w.done;
    return true;
  });
  ExpectCaught<rulings_t>(packets, channel::kRulings, "failure gone", [](rulings_t& r) {
    if (r.rulings.empty()) return false;
    r.rulings.pop_back();
    --r.n;
    return true;
  });
  ExpectCaught<schedule_t>(packets, channel::kSchedule, "action gone", [](schedule_t& s) {
    if (s.actions.empty() || s.actions.back().kind < 7) return false;
    s.weight -= s.actions.back().weight;
    s.actions.pop_back();
    --s.n;
    return true;
  });
  ExpectCaught<event_t>(packets, channel::kEvent, "event's time", [](event_t& e) {
    ++e.at_us;
    return true;
  });
}

/// Edits every message of a type on a channel for which `edit` returns true.
template <class Message>
int EditAll(std::vector<Packet>* packets, std::string_view channel,
            const std::function<bool(Message&)>& edit) {
  int edited = 0;
  for (Packet& packet : *packets) {
    if (packet.channel != channel) continue;
    Message message = *Decode<Message>(packet.bytes);
    if (!edit(message)) continue;
    packet.bytes = Encode(message);
    ++edited;
  }
  return edited;
}

audit::Violation FirstViolation(const std::vector<Packet>& packets) {
  audit::Auditor auditor;
  for (const Packet& packet : packets) auditor.Add(packet);
  const auto& violations = auditor.Finish();
  return violations.empty() ? audit::Violation() : violations.front();
}

TEST(AuditMission, CatchesAMeetingThatLastsTooShort) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.rules.limit_us = 90 * kMinuteUs;
  settings.rules.start_on_meeting = true;
  std::vector<Packet> packets = PacketsOf(Generate(settings, 1), "greedy-nearest");
  std::optional<activity_t> first;
  ASSERT_GT(
      EditAll<world_state_t>(&packets, channel::kWorld,
                             [&](world_state_t& w) {
                               bool edited = false;
                               for (activity_t& a : w.activities) {
                                 if (!first) first = a;
                                 if (a.uav_id != first->uav_id || a.start_us != first->start_us) {
                                   continue;
                                 }
                                 a.end_us -= 5;
                                 edited = true;
                               }
                               return edited;
                             }),
      0);
  const audit::Violation violation = FirstViolation(packets);
  EXPECT_EQ(violation.invariant, "meeting");
  EXPECT_EQ(violation.at_us, first->start_us);
  EXPECT_NE(violation.text.find("should take"), std::string::npos) << violation.text;
}

/// An hour of Random_1 with a zone over all of it, from that height on and until then.
Scenario BelowAZone(double lower_m, TimeUs until_us) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.rules.limit_us = 60 * kMinuteUs;
  Scenario scenario = Generate(settings, 1);
  ScenarioAir air;
  PlannedZone& zone = air.zones.emplace_back();
  zone.zone.rings = {{{0, 0}, {30'000, 0}, {30'000, 30'000}, {0, 30'000}}};
  zone.lower_m = lower_m;
  zone.until_us = until_us;
  UseAir(std::move(air), &scenario);
  return scenario;
}

TEST(AuditMission, CatchesAUavThatDoesNotFlyBelowAZone) {
  const Scenario scenario = BelowAZone(60, kNever);
  std::vector<Packet> packets = PacketsOf(scenario, "certified");
  ASSERT_EQ(FirstViolation(packets).text, "");
  bool is_edited = false;
  EditAll<clearances_t>(&packets, channel::kClearances, [&](clearances_t& message) {
    for (clearance_t& c : message.clearances) {
      EXPECT_LE(c.to_m, 50);
      if (message.decision == 1 && c.decision == 1 && !is_edited) c.to_m = 120, is_edited = true;
    }
    return message.decision == 1;
  });
  ASSERT_TRUE(is_edited);
  const audit::Violation violation = FirstViolation(packets);
  EXPECT_EQ(violation.invariant, "separation");
  EXPECT_NE(violation.text.find("in a zone that begins at 60.0 m"), std::string::npos)
      << violation.text;
}

TEST(AuditMission, LetsUavsFlyAsHighAsTheyLikeWhereAZoneHasEnded) {
  const Scenario scenario = BelowAZone(40, 20 * kMinuteUs);
  std::vector<Packet> packets;
  bool is_higher = false;
  Simulate(ScenarioToJson(scenario), "certified", [&](const Packet& packet) {
    packets.push_back(packet);
    if (packet.channel != channel::kClearances) return;
    const auto message = Decode<clearances_t>(packet.bytes);
    for (const clearance_t& c : message->clearances) is_higher |= c.to_m > 40;
  });
  EXPECT_EQ(FirstViolation(packets).text, "");
  EXPECT_TRUE(is_higher);
}

TEST(AuditMission, CatchesAltitudesThatDoNotKeepUavsApart) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.rules.limit_us = 60 * kMinuteUs;
  Scenario scenario = Generate(settings, 1);
  UseAir({}, &scenario);
  std::vector<Packet> packets = PacketsOf(scenario, "certified");
  ASSERT_EQ(FirstViolation(packets).text, "");
  const auto found = [&](const std::function<bool(clearances_t&)>& edit) {
    std::vector<Packet> edited = packets;
    EXPECT_GT(EditAll<clearances_t>(&edited, channel::kClearances, edit), 0);
    const audit::Violation violation = FirstViolation(edited);
    return violation.invariant + ": " + violation.text;
  };
  // The altitudes that decision 2 gives; later ones would follow from them.
  const auto new_ones = [&](const std::function<void(clearance_t&)>& edit) {
    return found([&](clearances_t& message) {
      if (message.decision != 2) return false;
      for (clearance_t& c : message.clearances) {
        if (c.decision == 2) edit(c);
      }
      return true;
    });
  };
  const auto has = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  std::string text = new_ones([](clearance_t& c) { c.to_m = 30; });
  EXPECT_TRUE(has(text, "separation: ") && has(text, "come within")) << text;
  text = new_ones([](clearance_t& c) { c.to_m += 5; });
  EXPECT_TRUE(has(text, "which is no altitude of this mission")) << text;
  text = new_ones([](clearance_t& c) { c.to_m = 130; });
  EXPECT_TRUE(has(text, "which is no altitude of this mission")) << text;
  text = new_ones([](clearance_t& c) { c.from_m += 1; });
  EXPECT_TRUE(has(text, "above the ground, expected")) << text;
  text = new_ones([](clearance_t& c) { c.begin_us += 121 * kSecondUs; });
  EXPECT_TRUE(has(text, "waits 121000000 us for its altitude")) << text;
  text = new_ones([](clearance_t& c) { c.decision = 1; });
  EXPECT_TRUE(has(text, "has another altitude than decision")) << text;
  text = found([](clearances_t& message) {
    if (message.decision != 2) return false;
    message.clearances.clear();
    message.n = 0;
    return true;
  });
  EXPECT_TRUE(has(text, "is sent off without an altitude")) << text;
  // A UAV that waits 5 s sets out 5 s later.
  text = new_ones([](clearance_t& c) { c.begin_us += 5 * kSecondUs; });
  EXPECT_TRUE(has(text, "motion: ") || has(text, "speed: ") || has(text, "come within")) << text;
  std::vector<Packet> without = packets;
  std::erase_if(without, [](const Packet& p) { return p.channel == channel::kClearances; });
  text = FirstViolation(without).text;
  EXPECT_TRUE(has(text, "clearances_t of decision 0")) << text;
}

/// Two UAVs come within 20 m of each other, and the second flies a third as far: wherever it is
/// seen from the first, they are too close at one altitude.
TEST(AuditMission, CatchesUavsBesideEachOtherAtOneAltitude) {
  const auto violation_of = [](Point ahead, Point beside) {
    const Point middle{5000, 5000};
    const auto place = [&](double ahead_m, double beside_m) {
      return Point{middle.x_m + ahead_m * ahead.x_m + beside_m * beside.x_m,
                   middle.y_m + ahead_m * ahead.y_m + beside_m * beside.y_m};
    };
    Scenario scenario;
    scenario.width_m = scenario.height_m = 10'000;
    scenario.rules.limit_us = 20 * kMinuteUs;
    scenario.rules.interval_us = 5 * kMinuteUs;
    for (const int i : {0, 1}) {
      AgentSpec agent{.at = place(0, 80 * i), .speed_m_s = 10};
      agent.online_until_us = scenario.rules.limit_us;
      agent.range_full_m = agent.range_m = 20'000;
      scenario.uavs.push_back(agent);
      const Point at = place(i == 0 ? 3000 : 1000, 20 * i);
      scenario.tasks.push_back({.at = at, .cost_m = 300});
      agent.at = at;
      scenario.workers.push_back(agent);
      agent.charge_rate_m_s = 50;
      scenario.vehicles.push_back(agent);
    }
    scenario.charging_points = {{.at = {100, 100}}};
    UseAir({}, &scenario);
    std::vector<Packet> packets = PacketsOf(scenario, "certified");
    EXPECT_EQ(FirstViolation(packets).text, "");
    EXPECT_GT(EditAll<clearances_t>(&packets, channel::kClearances,
                                    [](clearances_t& message) {
                                      for (clearance_t& c : message.clearances) c.to_m = 30;
                                      return true;
                                    }),
              0);
    return FirstViolation(packets).text;
  };
  for (const double ahead : {-1.0, 1.0}) {
    for (const double beside : {-1.0, 1.0}) {
      for (const std::string& text :
           {violation_of({ahead, 0}, {0, beside}), violation_of({0, ahead}, {beside, 0})}) {
        EXPECT_NE(text.find("come within"), std::string::npos) << text;
      }
    }
  }
}

TEST(AuditMission, KnowsAltitudesThatAreNoMultiplesOfTheirDistance) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.rules.limit_us = 60 * kMinuteUs;
  Scenario scenario = Generate(settings, 1);
  ScenarioAir air;
  air.separation = Separation{};
  air.separation->lowest_m = 33;
  UseAir(std::move(air), &scenario);
  std::vector<Packet> packets = PacketsOf(scenario, "certified");
  EXPECT_EQ(FirstViolation(packets).text, "");
  EXPECT_GT(EditAll<clearances_t>(&packets, channel::kClearances,
                                  [](clearances_t& message) {
                                    for (clearance_t& c : message.clearances) c.to_m = 40;
                                    return message.decision == 2;
                                  }),
            0);
  EXPECT_NE(FirstViolation(packets).text.find("is no altitude of this mission"), std::string::npos);
}

TEST(AuditMission, CatchesACommandToAFailedAgent) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.rules.limit_us = 90 * kMinuteUs;
  settings.disturbances.agent_failure = {0.1, 0.2};
  std::vector<Packet> packets = PacketsOf(Generate(settings, 1), "mpq");
  ASSERT_EQ(FirstViolation(packets).text, "");
  std::optional<ruling_t> failed;
  std::int64_t failed_tick = 0;
  for (const Packet& packet : packets) {
    if (packet.channel != channel::kRulings || failed) continue;
    const auto rulings = Decode<rulings_t>(packet.bytes);
    for (const ruling_t& r : rulings->rulings) {
      if (r.kind != 0 || r.agent_kind != 1) continue;
      failed = r;
      failed_tick = rulings->tick;
    }
  }
  ASSERT_TRUE(failed);
  std::int64_t decision_tick = -1;
  ASSERT_EQ(EditAll<schedule_t>(&packets, channel::kSchedule,
                                [&](schedule_t& s) {
                                  if (s.tick <= failed_tick || decision_tick >= 0) return false;
                                  decision_tick = s.tick;
                                  action_t stay{};
                                  stay.kind = 1;
                                  stay.uav_id = stay.vehicle_id = stay.task_id = stay.charge_id =
                                      -1;
                                  stay.worker_id = failed->agent_id;
                                  s.actions.push_back(stay);
                                  ++s.n;
                                  return true;
                                }),
            1);
  const audit::Violation violation = FirstViolation(packets);
  EXPECT_EQ(violation.invariant, "idle-agents-only");
  EXPECT_EQ(violation.at_us, decision_tick * settings.rules.tick_us);
  EXPECT_NE(violation.text.find("worker:" + std::to_string(failed->agent_id) + " is failed"),
            std::string::npos)
      << violation.text;
}

}  // namespace
}  // namespace muster::tools
