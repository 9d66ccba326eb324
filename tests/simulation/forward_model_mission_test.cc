#include <gtest/gtest.h>

#include <string>

#include "model/generator.h"
#include "model/scenario_json.h"
#include "scheduler/policies/horizon/horizon.h"
#include "scheduler/policies/rollout/forward_model.h"
#include "simulation/simulator.h"
#include "tests/simulation/audited.h"
#include "tools/record/run_record.h"

namespace muster::tools {
namespace {

/// Everybody is online from the start, so that the forward model knows all that the mission does.
Scenario KnownToAll(std::uint64_t seed, Availability availability) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.width_km = settings.height_km = 15;
  settings.uavs = 8;
  settings.workers = 12;
  settings.vehicles = 5;
  settings.tasks = 40;
  settings.charging_points = 5;
  settings.rules.availability = availability;
  Scenario scenario = Generate(settings, seed);
  for (const AgentKind kind : kAgentKinds) {
    auto& agents = ByKind(kind, scenario.uavs, scenario.workers, scenario.vehicles);
    for (AgentSpec& agent : agents) {
      agent.online_from_us = 0;
      agent.online_until_us = (40 + static_cast<int>(seed) * 13) * kMinuteUs;
    }
  }
  return scenario;
}

TEST(ForwardModel, GivesTheMissionsOutcomes) {
  std::size_t done = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scenario scenario =
        KnownToAll(seed, seed % 2 == 0 ? Availability::kStrict : Availability::kOverrun);
    RunRecord record;
    Audited audited;
    Simulate(ScenarioToJson(scenario), "horizon", [&](const Packet& packet) {
      record.Add(packet);
      audited.Add(packet);
    });

    scheduler::Situation situation;
    situation.site = std::make_shared<const scheduler::Site>(*record.scenario());
    situation.task_status.assign(scenario.tasks.size(), TaskStatus::kOpen);
    situation.charging_load.assign(scenario.charging_points.size(), 0);
    const auto start = [&](AgentKind kind, std::vector<AgentState>* agents) {
      for (const AgentSpec& spec : record.scenario()->agents(kind)) {
        agents->push_back(
            StartOf(kind, static_cast<std::int32_t>(agents->size()), spec, StraightWays()));
      }
    };
    start(AgentKind::kUav, &situation.uavs);
    start(AgentKind::kWorker, &situation.workers);
    start(AgentKind::kVehicle, &situation.vehicles);

    scheduler::ForwardModel model(situation);
    scheduler::HorizonPolicy policy;
    for (std::int32_t decision = 0; !model.over(); ++decision) {
      const auto actions = policy.Decide(model.situation()).actions;
      const auto commanded = record.schedules().find(decision);
      ASSERT_NE(commanded, record.schedules().end());
      ASSERT_EQ(commanded->second.actions.size(), actions.size()) << "decision " << decision;
      for (std::size_t i = 0; i < actions.size(); ++i) {
        const auto& wire = commanded->second.actions[i];
        EXPECT_EQ(wire.kind, static_cast<std::int8_t>(actions[i].kind));
        EXPECT_EQ(wire.uav_id, actions[i].uav.value);
        EXPECT_EQ(wire.worker_id, actions[i].worker.value);
        EXPECT_EQ(wire.vehicle_id, actions[i].vehicle.value);
        EXPECT_EQ(wire.task_id, actions[i].task.value);
        EXPECT_EQ(wire.charge_id, actions[i].charge.value);
        EXPECT_EQ(wire.x_m, actions[i].to.x_m);
        EXPECT_EQ(wire.y_m, actions[i].to.y_m);
      }
      model.Step(actions);
    }
    done += model.done().size();
  }
  EXPECT_GT(done, 60u);
}

}  // namespace
}  // namespace muster::tools
