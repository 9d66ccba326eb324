// What the audit says of logs in which one thing was edited, as it was when this was written: edits
// of every field by little and by much, of messages that are gone, double or late, and of each
// number of the scenario and the report. findings.txt has one line for each kind of edit: how many
// of them were found, and a hash of all that was said. Where a change is meant to move them, the
// lines that a failure prints belong in that file, and the reason in its commit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "base/random.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "model/generator.h"
#include "model/scenario_json.h"
#include "simulation/simulator.h"
#include "tests/tools/audit/edits.h"
#include "tests/tools/fake_mission.h"
#include "tools/audit/auditor.h"
#include "tools/audit/report_check.h"
#include "tools/record/report_json.h"
#include "tools/record/run_record.h"

namespace muster::tools {
namespace {

using Json = nlohmann::json;
using testing::AuditOf;
using testing::Change;
using testing::Edit;
using testing::Field;
using testing::Findings;
using testing::ItemField;
using testing::ItemGoneOrTwice;
using testing::kEditsOfAKind;
using testing::Packets;
using testing::TextOf;

Packets Small(const std::string& policy, const std::function<void(GeneratorSettings*)>& change) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.width_km = settings.height_km = 7;
  settings.uavs = 3;
  settings.workers = 3;
  settings.vehicles = 2;
  settings.tasks = 6;
  settings.charging_points = 2;
  settings.task_cost_km = {1, 4};
  settings.full_range_km = 14;
  settings.start_fraction = {0.5, 1};
  settings.uptime = Uptime::kAnyTime;
  settings.online_min = {20, 60};
  settings.rules.limit_us = 60 * kMinuteUs;
  settings.rules.tick_us = 150 * kSecondUs;
  change(&settings);
  Packets packets;
  std::map<std::string, std::int64_t> seqs;
  std::set<std::pair<std::string, std::int64_t>> seen;
  const auto keep = [&](const Packet& packet, auto message) {
    if (!message || !seen.emplace(message->header.sender, message->header.seq).second) return;
    message->header.seq = seqs[message->header.sender]++;
    packets.push_back({packet.channel, Encode(*message)});
  };
  // Without what processes say of themselves.
  Simulate(ScenarioToJson(Generate(settings, 5)), policy, [&](const Packet& packet) {
    keep(packet, Decode<scenario_t>(packet.bytes));
    keep(packet, Decode<clock_t>(packet.bytes));
    keep(packet, Decode<world_state_t>(packet.bytes));
    keep(packet, Decode<rulings_t>(packet.bytes));
    keep(packet, Decode<agent_states_t>(packet.bytes));
    keep(packet, Decode<schedule_t>(packet.bytes));
    keep(packet, Decode<event_t>(packet.bytes));
  });
  return packets;
}

struct Mission {
  const char* name;
  Packets packets;
};

const std::vector<Mission>& Missions() {
  static const std::vector<Mission> missions = {
      {"by-hand", Encoded(MakeFakeMission(150 * kSecondUs))},
      {"storm", Small("mpq",
                      [](GeneratorSettings* s) {
                        s->disturbances = {{0.2, 0.6}, {100, 900}, {0.02, 0.1}, {0.1, 0.4}};
                        s->rules.availability = Availability::kOverrun;
                      })},
      {"meetings", Small("greedy-nearest",
                         [](GeneratorSettings* s) {
                           s->rules.start_on_meeting = true;
                           s->disturbances.agent_failure = {0.01, 0.05};
                         })},
      {"steps", Small("horizon-steps", [](GeneratorSettings*) {})},
  };
  return missions;
}

void EditAgents(Findings* findings, const Packets& packets) {
  using States = agent_states_t;
  const auto edit = [&](const std::string& name, auto field) {
    Edit<States>(findings, packets, "agent " + name, ItemField(&States::agents, field));
  };
  edit("id", &agent_t::id);
  edit("x", &agent_t::x_m);
  edit("y", &agent_t::y_m);
  edit("speed", &agent_t::speed_m_s);
  edit("range", &agent_t::range_left_m);
  edit("full range", &agent_t::range_full_m);
  edit("charge rate", &agent_t::charge_rate_m_s);
  edit("range at departure", &agent_t::range_at_departure_m);
  edit("departure", &agent_t::depart_us);
  edit("arrival", &agent_t::arrive_us);
  edit("online from", &agent_t::online_from_us);
  edit("online until", &agent_t::online_until_us);
  edit("busy until", &agent_t::busy_until_us);
  edit("status", &agent_t::status);
  edit("action", &agent_t::action);
  edit("target", &agent_t::target_id);
  edit("partner", &agent_t::partner_id);
  Edit<States>(findings, packets, "agents kind", Field(&States::kind));
  Edit<States>(findings, packets, "agents tick", Field(&States::tick));
  Edit<States>(findings, packets, "agents decision", Field(&States::applied_decision));
  Edit<States>(findings, packets, "agent gone or twice",
               ItemGoneOrTwice(&States::agents, &States::n));
}

void EditWorld(Findings* findings, const Packets& packets) {
  using World = world_state_t;
  const auto activity = [&](const std::string& name, auto field) {
    Edit<World>(findings, packets, "activity " + name, ItemField(&World::activities, field));
  };
  activity("kind", &activity_t::kind);
  activity("uav", &activity_t::uav_id);
  activity("partner", &activity_t::partner_id);
  activity("site", &activity_t::site_id);
  activity("start", &activity_t::start_us);
  activity("end", &activity_t::end_us);
  Edit<World>(findings, packets, "activity gone or twice",
              ItemGoneOrTwice(&World::activities, &World::n_activities));
  Edit<World>(findings, packets, "world tick", Field(&World::tick));
  Edit<World>(findings, packets, "world done", Field(&World::done));
  Edit<World>(findings, packets, "task status", [](World& world, int i, Random* random) {
    const auto x = random->Below(static_cast<std::uint32_t>(world.task_status.size()));
    world.task_status[x] = static_cast<std::int8_t>(i % 4);
    return true;
  });
  Edit<World>(findings, packets, "task status gone or twice",
              ItemGoneOrTwice(&World::task_status, &World::n_tasks));

  const auto ruling = [&](const std::string& name, auto field) {
    Edit<rulings_t>(findings, packets, "ruling " + name, ItemField(&rulings_t::rulings, field));
  };
  ruling("class", &ruling_t::agent_kind);
  ruling("agent", &ruling_t::agent_id);
  ruling("kind", &ruling_t::kind);
  ruling("time", &ruling_t::at_us);
  Edit<rulings_t>(findings, packets, "ruling gone or twice",
                  ItemGoneOrTwice(&rulings_t::rulings, &rulings_t::n));
  Edit<rulings_t>(findings, packets, "ruling more", [](rulings_t& r, int i, Random* random) {
    const auto id = static_cast<std::int32_t>(random->Below(3));
    r.rulings.push_back({static_cast<std::int8_t>(i % 3), id, static_cast<std::int8_t>(i % 2),
                         r.tick * 150 * kSecondUs - i % 5});
    ++r.n;
    return true;
  });

  Edit<clock_t>(findings, packets, "clock tick", Field(&clock_t::tick));
  Edit<clock_t>(findings, packets, "clock time", Field(&clock_t::tick_us));
  Edit<clock_t>(findings, packets, "clock limit", Field(&clock_t::limit_us));
  Edit<clock_t>(findings, packets, "clock decision", Field(&clock_t::decision));
  Edit<clock_t>(findings, packets, "clock required", Field(&clock_t::required_decision));
  Edit<clock_t>(findings, packets, "clock phase", Field(&clock_t::phase));

  Edit<event_t>(findings, packets, "event kind", Field(&event_t::kind));
  Edit<event_t>(findings, packets, "event time", Field(&event_t::at_us));
  Edit<event_t>(findings, packets, "event uav", Field(&event_t::uav_id));
  Edit<event_t>(findings, packets, "event worker", Field(&event_t::worker_id));
  Edit<event_t>(findings, packets, "event vehicle", Field(&event_t::vehicle_id));
  Edit<event_t>(findings, packets, "event task", Field(&event_t::task_id));
  Edit<event_t>(findings, packets, "event charge", Field(&event_t::charge_id));
}

void EditSchedule(Findings* findings, const Packets& packets) {
  using Schedule = schedule_t;
  const auto action = [&](const std::string& name, auto field) {
    Edit<Schedule>(findings, packets, "action " + name, ItemField(&Schedule::actions, field));
  };
  action("kind", &action_t::kind);
  action("uav", &action_t::uav_id);
  action("worker", &action_t::worker_id);
  action("vehicle", &action_t::vehicle_id);
  action("task", &action_t::task_id);
  action("charge", &action_t::charge_id);
  action("x", &action_t::x_m);
  action("y", &action_t::y_m);
  action("weight", &action_t::weight);
  Edit<Schedule>(findings, packets, "action gone or twice",
                 ItemGoneOrTwice(&Schedule::actions, &Schedule::n));
  Edit<Schedule>(findings, packets, "schedule decision", Field(&Schedule::decision));
  Edit<Schedule>(findings, packets, "schedule tick", Field(&Schedule::tick));
  Edit<Schedule>(findings, packets, "schedule weight", Field(&Schedule::weight));
  Edit<Schedule>(findings, packets, "schedule bound", [](Schedule& s, int i, Random*) {
    s.bound = s.weight;
    Change(&s.bound, i);
    return true;
  });
}

/// What a sender, a network or a logger may do to whole messages.
void EditPackets(Findings* findings, const Packets& packets) {
  Random random(1, Stream::kTest);
  for (int i = 0; i < 5 * kEditsOfAKind; ++i) {
    Packets edited = packets;
    const auto at =
        static_cast<std::ptrdiff_t>(random.Below(static_cast<std::uint32_t>(packets.size())));
    const Packet packet = packets[static_cast<std::size_t>(at)];
    switch (i % 5) {
      case 0:
        edited.erase(edited.begin() + at);
        findings->Add("message gone", edited);
        break;
      case 1:
        edited.push_back(packet);
        findings->Add("message twice", edited);
        break;
      case 2:
        edited.erase(edited.begin() + at);
        edited.push_back(packet);
        findings->Add("message late", edited);
        break;
      case 3:
        edited[static_cast<std::size_t>(at)].bytes.back() ^= 0x81;
        findings->Add("message damaged", edited);
        break;
      case 4:
        edited.resize(static_cast<std::size_t>(at));
        findings->Add("log cut off", edited);
        break;
    }
  }
  const auto header = [&](const std::string& name, auto field) {
    const auto of = [&](auto type) {
      using Message = decltype(type);
      Edit<Message>(findings, packets, "header " + name, [&](Message& message, int i, Random*) {
        if constexpr (std::is_same_v<decltype(field), std::string header_t::*>) {
          message.header.*field += 'x';
        } else {
          Change(&(message.header.*field), i);
        }
        return true;
      });
    };
    of(clock_t());
    of(agent_states_t());
    of(event_t());
    of(schedule_t());
  };
  header("run", &header_t::run_id);
  header("sender", &header_t::sender);
  header("start", &header_t::boot_id);
  header("seq", &header_t::seq);
  header("time", &header_t::sim_us);
}

/// Each number of the scenario, one at a time: the mission's messages are then those of another.
void EditScenario(Findings* findings, const Packets& packets) {
  std::size_t at = 0;
  while (!Decode<scenario_t>(packets[at].bytes)) ++at;
  const scenario_t scenario = *Decode<scenario_t>(packets[at].bytes);
  const Json whole = Json::parse(scenario.json), leaves = whole.flatten();
  for (const auto& [pointer, value] : leaves.items()) {
    if (!value.is_number() || pointer.ends_with("/id") || pointer == "/version") continue;
    for (const double by : {0.001, -0.001, 3.0}) {
      Json edited = whole;
      edited[Json::json_pointer(pointer)] = value.get<double>() + by;
      scenario_t message = scenario;
      message.json = edited.dump();
      message.sha256 = audit::Sha256Of(message.json);
      Packets all = packets;
      all[at].bytes = Encode(message);
      const std::string list = pointer.substr(1, pointer.find('/', 1) - 1);
      const std::string key = pointer.substr(pointer.rfind('/') + 1);
      findings->Add("scenario " + list + (key == list ? "" : " " + key), all);
    }
  }
}

/// Each value of the report that the log knows better, one at a time.
void EditReport(Findings* findings, const Packets& packets) {
  audit::Auditor auditor;
  RunRecord record;
  for (const Packet& packet : packets) {
    auditor.Add(packet);
    record.Add(packet);
  }
  ASSERT_TRUE(auditor.Finish().empty());
  const Json report = Json::parse(Report(record).dump()), leaves = report.flatten();
  const auto check = [&](const std::string& kind, const Json& edited) {
    const auto violations = audit::CheckReportFile(edited, *auditor.facts());
    findings->Add(kind, !violations.empty(), TextOf(violations));
  };
  const std::set<std::string> of_the_log = {
      "charges", "completion_rate", "decisions",  "digest",      "events", "flown_m", "scenario",
      "seed",    "tasks",           "tasks_done", "tasks_total", "uavs",   "version"};
  check("report as it is", report);
  for (const auto& [pointer, value] : leaves.items()) {
    const Json::json_pointer at(pointer);
    const std::string list = pointer.substr(1, pointer.find('/', 1) - 1);
    if (!of_the_log.contains(list)) continue;
    const std::string kind = "report " + list;
    Json edited = report;
    edited[at] = value.is_number() ? Json(value.get<double>() * 1.00001 + 1) : Json("x");
    check(kind, edited);
    edited[at] = nullptr;
    check(kind, edited);
  }
}

/// All in one cell of 1 km: who is free meets at once.
TEST(AuditMeetings, BeginWithTheFirstDecision) {
  const Packets packets = Small("greedy-nearest", [](GeneratorSettings* s) {
    s->width_km = s->height_km = 1;
    s->uptime = Uptime::kWithinLimit;
    s->online_min = Always(60);
    s->rules.start_on_meeting = true;
  });
  bool found = false;
  const std::string text = AuditOf(packets, &found);
  EXPECT_FALSE(found) << text;
  const auto begun = std::count_if(packets.begin(), packets.end(), [](const Packet& packet) {
    const auto event = Decode<event_t>(packet.bytes);
    return event && event->kind == EventKind::kSensingStarted && event->at_us == 0;
  });
  EXPECT_GT(begun, 0) << text;
}

class AuditFindings : public ::testing::TestWithParam<std::size_t> {};

TEST_P(AuditFindings, AreThoseTheyWere) {
  const Mission& mission = Missions()[GetParam()];
  Findings findings(mission.name);
  bool found = false;
  AuditOf(mission.packets, &found);
  ASSERT_FALSE(found) << AuditOf(mission.packets, &found);
  EditAgents(&findings, mission.packets);
  EditWorld(&findings, mission.packets);
  EditSchedule(&findings, mission.packets);
  EditPackets(&findings, mission.packets);
  EditScenario(&findings, mission.packets);
  EditReport(&findings, mission.packets);

  findings.ExpectThoseOf(MUSTER_SOURCE_DIR "/tests/tools/audit/findings.txt");
}

INSTANTIATE_TEST_SUITE_P(, AuditFindings, ::testing::Range(std::size_t{0}, Missions().size()),
                         [](const auto& mission) {
                           std::string name = Missions()[mission.param].name;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace muster::tools
