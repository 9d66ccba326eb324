// Missions in which much coincides: all places on a grid, all times in whole minutes, so that ways
// are equally long, ranges just suffice, agents arrive in the tick of a decision, and places lie on
// the edges of zones and on streets. In missions with random places nothing of this ever happens,
// so a `<` instead of a `<=` changes nothing there. coincidences.txt has what the missions come to
// and what is said of them. Where a change is meant to move outcomes, the new lines
// (printed by a failure) and the reason belong in its commit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "model/generator.h"
#include "model/made_up.h"
#include "scheduler/policies/external/situation_json.h"
#include "tests/simulation/order_draws.h"
#include "tests/tools/audit/edits.h"
#include "tools/explain/decision_log.h"
#include "tools/explain/story.h"
#include "tools/graph/situations.h"
#include "tools/record/digest.h"
#include "tools/record/run_record.h"
#include "tools/simulate/virtual_mission.h"
#include "tools/trials/draws.h"

namespace muster::tools {
namespace {

constexpr double kMeshM = 500;  ///< half a minute of a UAV's way, a minute of a worker's

double OnMesh(double metres) { return std::round(metres / kMeshM) * kMeshM; }
TimeUs OnFiveMinutes(TimeUs t) {
  return (t + 5 * kMinuteUs / 2) / (5 * kMinuteUs) * (5 * kMinuteUs);
}

Scenario MeshScenario(std::uint64_t seed) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.width_km = settings.height_km = 8;
  settings.uavs = 6;
  settings.workers = 7;
  settings.vehicles = 3;
  settings.tasks = 26;
  settings.charging_points = 4;
  settings.online_min = {30, 60};
  settings.uptime = Uptime::kAnyTime;
  settings.placement = Placement::kContinuous;
  settings.task_cost_km = {0.5, 3};
  settings.charge_km_per_min = {1, 3};
  settings.vehicle_speed_km_per_min = 1;
  settings.full_range_km = 10;
  settings.start_fraction = {0.2, 1};
  settings.arrivals.share = seed % 3 == 0 ? 0.4 : 0;
  settings.priority_shares = {1, 2, 1, 1};
  settings.due_min = {DrawRange{10, 30}, DrawRange{10, 30}, DrawRange{10, 30}, DrawRange{5, 10}};
  settings.rules.limit_us = 60 * kMinuteUs;
  settings.rules.interval_us = seed % 4 == 0 ? 10 * kMinuteUs : 5 * kMinuteUs;
  settings.rules.ceil_to_minutes = seed % 5 == 0;
  settings.rules.mean_over_all = seed % 5 == 1;
  settings.rules.start_on_meeting = seed % 5 == 2;
  settings.rules.emergencies_at_once = seed % 5 == 3;
  if (seed % 2 == 1) settings.rules.availability = Availability::kOverrun;
  Scenario scenario = Generate(settings, seed);
  const auto snap = [](Point* at) { *at = {OnMesh(at->x_m), OnMesh(at->y_m)}; };
  for (auto* agents : {&scenario.uavs, &scenario.workers, &scenario.vehicles}) {
    for (AgentSpec& agent : *agents) {
      snap(&agent.at);
      agent.range_m = OnMesh(agent.range_m);
      agent.charge_rate_m_s = std::round(agent.charge_rate_m_s * 60 / kMeshM) * kMeshM / 60;
      agent.online_from_us = OnFiveMinutes(agent.online_from_us);
      agent.online_until_us = OnFiveMinutes(agent.online_until_us);
    }
  }
  for (Task& task : scenario.tasks) {
    snap(&task.at);
    task.cost_m = OnMesh(task.cost_m);
    task.reported_us = OnFiveMinutes(task.reported_us);
    if (task.due_us != kNever) task.due_us = OnFiveMinutes(task.due_us);
  }
  for (ChargingPoint& point : scenario.charging_points) snap(&point.at);
  return scenario;
}

/// Rectangles along the mesh, some of which touch or begin and end when decisions are made.
void AddZones(std::uint64_t seed, Scenario* scenario) {
  Random random(seed, Stream::kTest, 5);
  ScenarioAir air;
  air.margin_m = seed % 2 == 0 ? 250 : 30;
  if (seed % 8 < 4) air.separation.reset();
  for (std::uint32_t n = 1 + random.Below(4); n > 0; --n) {
    const double left = kMeshM * random.Below(13), bottom = kMeshM * random.Below(13);
    const double right = left + kMeshM * (1 + random.Below(4));
    const double top = bottom + kMeshM * (1 + random.Below(4));
    PlannedZone& planned = air.zones.emplace_back();
    planned.zone.rings = {{{left, bottom}, {right, bottom}, {right, top}, {left, top}}};
    if (random.Below(3) == 0) planned.lower_m = 60;
    if (random.Below(2) == 0) planned.from_us = 5 * kMinuteUs * TimeUs{random.Below(8)};
    if (random.Below(2) == 0) {
      planned.until_us = planned.from_us + 5 * kMinuteUs * TimeUs{1 + random.Below(6)};
    }
  }
  UseAir(std::move(air), scenario);
}

VirtualMission MeshMission(std::uint64_t seed, const std::string& policy) {
  VirtualMission mission{MeshScenario(seed), policy};
  mission.fault_seed = seed;
  Random random(seed, Stream::kTest, 6);
  if (seed % 4 < 2) {
    ScenarioRoads roads;
    roads.file = "mesh.roads.json";
    roads.text = RoadsToJson(StreetGrid(8, 1000, seed, true));
    if (seed % 3 == 0) roads.open_ground = {{}, {0, 1000}, {50, 1000}};
    UseRoads(std::move(roads), "mesh.roads.json", &mission.scenario);
    if (seed % 8 < 4) DrawClosures(&random, &mission);
  }
  if (seed % 3 > 0) AddZones(seed, &mission.scenario);
  if (seed % 2 == 0) AddRoom({4, {2, 2, 2}}, &mission.scenario);
  if (mission.scenario.takes_orders()) {
    for (auto draw : {DrawTaskOrders, DrawDirectives}) {
      for (world::PlannedOrder& order : draw(mission.scenario, &random)) {
        mission.orders.push_back(std::move(order));
      }
    }
  }
  return mission;
}

/// Digest of the outcome, hash of explanations (each fifth task, an agent of each class), hash of
/// all situations as external schedulers are told them. Fails where the audit finds anything.
std::string Line(std::uint64_t seed, const std::string& policy) {
  VirtualMission mission = MeshMission(seed, policy);
  RunRecord record;
  Packets packets;
  SituationRecorder situations;
  audit::Auditor auditor;
  mission.on_logged = [&](const simulation::VirtualLogger::Event& event, std::int64_t) {
    record.Add(*event.packet);
    situations.Add(*event.packet);
    auditor.Add(*event.packet);
    packets.all.push_back(*event.packet);
  };
  RunVirtualMission(mission);
  const DecisionLog log = ReadDecisionLog(&packets);
  std::string stories;
  std::vector<std::int32_t> tasks;
  for (std::size_t i = 0; i < log.scenario.tasks.size(); i += 5) {
    tasks.push_back(static_cast<std::int32_t>(i));
  }
  for (const TaskStory& story : TellTasks(log, "", tasks, std::nullopt)) {
    stories += ToText(story) + ToJson(story).dump();
  }
  for (const AgentKind kind : kAgentKinds) {
    const AgentStory story = TellAgent(log, "", kind, static_cast<std::int32_t>(seed % 3), {});
    stories += ToText(story) + ToJson(story).dump();
  }
  std::string told;
  for (const scheduler::Situation& situation : situations.Situations()) {
    nlohmann::ordered_json json = scheduler::ToJson(situation);
    scheduler::AddGraph(situation, scheduler::EnumerateCandidates(situation), {true, true}, &json);
    told += json.dump();
  }
  const std::string findings = testing::TextOf(auditor.Finish());
  EXPECT_EQ(findings, "");
  return fmt::format("{} {}: {} {:08x} {:08x}", seed, policy, Digest(record).substr(0, 16),
                     testing::HashOf(stories), testing::HashOf(told));
}

class Coincidences : public ::testing::TestWithParam<std::string> {};

TEST_P(Coincidences, ComeToWhatTheyCameTo) {
  std::ifstream file(MUSTER_SOURCE_DIR "/tests/simulation/coincidences.txt");
  std::set<std::string> known;
  for (std::string line; std::getline(file, line);) known.insert(line);
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const std::string line = Line(seed, GetParam());
    EXPECT_TRUE(known.contains(line)) << line;
  }
}

INSTANTIATE_TEST_SUITE_P(Policies, Coincidences,
                         ::testing::Values("certified", "horizon", "rollout-steps", "mpq", "kwta",
                                           "greedy-nearest", "neighbours:reach=4"),
                         [](const auto& test) {
                           std::string name;
                           for (const char c : test.param) name += std::isalnum(c) ? c : '_';
                           return name;
                         });

}  // namespace
}  // namespace muster::tools
