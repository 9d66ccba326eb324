#include <gtest/gtest.h>

#include "agents/core/agent_process.h"
#include "scheduler/process/scheduler_process.h"
#include "tests/tools/virtual_network.h"
#include "tools/report/digest.h"
#include "tools/simulate/simulator.h"
#include "world/model/check.h"
#include "world/model/generator.h"
#include "world/model/scenario_json.h"
#include "world/truth/world_process.h"

namespace muster::tools {
namespace {

using testing::NetworkFaults;
using testing::VirtualNetwork;

Scenario SmallScenario() { return Generate(PresetByName("Random_10"), 5); }

std::string SimulatedDigest(const std::string& json) {
  RunRecord record;
  Simulate(json, "mpq", [&](const Packet& packet) { record.Add(packet); });
  return Digest(record);
}

struct Outcome {
  bool ended = false;
  std::string digest;
};

Outcome RunOver(const NetworkFaults& faults, std::uint64_t seed, const std::string& json,
                int uav_processes = 1) {
  VirtualNetwork network(faults, seed);
  auto world = std::make_unique<world::WorldProcess>(Identity{1, "world", 0}, 0, json,
                                                     world::WorldOptions());
  const world::WorldProcess& clock = *world;
  const auto n_uavs = static_cast<std::int32_t>(ParseScenario(json, "test").uavs.size());
  for (std::int32_t i = 0; i < uav_processes; ++i) {
    const agents::IdRange ids =
        std::pair(n_uavs * i / uav_processes, n_uavs * (i + 1) / uav_processes - 1);
    network.Add(std::make_unique<agents::AgentProcess>(Identity{1, "uav-" + std::to_string(i), 0},
                                                       0, AgentKind::kUav, ids));
  }
  for (const AgentKind kind : {AgentKind::kWorker, AgentKind::kVehicle}) {
    network.Add(std::make_unique<agents::AgentProcess>(Identity{1, std::string(ToString(kind)), 0},
                                                       0, kind, agents::IdRange()));
  }
  network.Add(std::make_unique<scheduler::SchedulerProcess>(Identity{1, "scheduler", 0}, 0, "mpq",
                                                            [] { return TimeUs{0}; }));
  network.Add(std::move(world));
  RunRecord record;
  Outcome outcome;
  outcome.ended = network.Run(
      3600 * kSecondUs, [&] { return clock.ended(); },
      [&](const Packet& packet) { record.Add(packet); });
  outcome.digest = Digest(record);
  return outcome;
}

TEST(Lockstep, OutcomeDoesNotDependOnLossDuplicationOrOrder) {
  const std::string json = ScenarioToJson(SmallScenario());
  const std::string expected = SimulatedDigest(json);
  const NetworkFaults none;
  EXPECT_EQ(RunOver(none, 1, json).digest, expected);
  const NetworkFaults bad{.loss = 0.3, .duplication = 0.1, .longest_delay_us = 3000};
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Outcome outcome = RunOver(bad, seed, json);
    EXPECT_TRUE(outcome.ended) << "seed " << seed;
    EXPECT_EQ(outcome.digest, expected) << "seed " << seed;
  }
}

TEST(Lockstep, AClassMayBeSplitOverProcesses) {
  const std::string json = ScenarioToJson(SmallScenario());
  EXPECT_EQ(RunOver({.loss = 0.1}, 1, json, 3).digest, SimulatedDigest(json));
}

TEST(Lockstep, TwoProcessesForOneAgentAreAnError) {
  const std::string json = ScenarioToJson(SmallScenario());
  VirtualNetwork network({}, 1);
  network.Add(std::make_unique<world::WorldProcess>(Identity{1, "world", 0}, 0, json,
                                                    world::WorldOptions()));
  for (const char* name : {"a", "b"}) {
    network.Add(std::make_unique<agents::AgentProcess>(Identity{1, name, 0}, 0, AgentKind::kUav,
                                                       agents::IdRange()));
  }
  EXPECT_THROW(network.Run(
                   10 * kSecondUs, [] { return false; }, [](const Packet&) {}),
               InputError);
}

TEST(Lockstep, OutcomeDoesNotDependOnTheTick) {
  Scenario scenario = SmallScenario();
  scenario.disturbances.wind = {0.1, 0.4};
  scenario.disturbances.communication_m = {100, 500};
  scenario.disturbances.match_failure = {0.05, 0.1};
  scenario.disturbances.agent_failure = {0.01, 0.05};
  std::vector<std::string> outcomes;
  for (const TimeUs tick_s : {10, 30, 600}) {
    scenario.rules.tick_us = tick_s * kSecondUs;
    RunRecord record;
    Simulate(ScenarioToJson(scenario), "mpq", [&](const Packet& packet) { record.Add(packet); });
    outcomes.push_back(Digest(record));
  }
  EXPECT_EQ(outcomes[0], outcomes[1]);
  EXPECT_EQ(outcomes[0], outcomes[2]);
}

}  // namespace
}  // namespace muster::tools
