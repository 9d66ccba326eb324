#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/random.h"
#include "model/generator.h"
#include "scheduler/situation.h"

namespace muster::scheduler::testing {

/// Situations as missions have them: the agents of a generated scenario that are online at a
/// decision, UAVs with any range, some tasks done.
inline Situation GeneratedSituation(const GeneratorSettings& settings, std::uint64_t seed,
                                    std::int32_t decision, double done) {
  const Scenario scenario = Generate(settings, seed);
  Random random(seed, Stream::kTest, 1, static_cast<std::uint32_t>(decision));
  Situation situation;
  situation.site = std::make_shared<const Site>(scenario);
  situation.decision = decision;
  situation.now_us = decision * scenario.rules.interval_us;
  const auto add = [&](AgentKind kind, std::vector<AgentState>* agents) {
    std::int32_t id = 0;
    for (const AgentSpec& spec : scenario.agents(kind)) {
      AgentState agent = StartOf(kind, id++, spec, *scenario.ways);
      if (kind == AgentKind::kUav) agent.range_at_departure_m *= random.Uniform(0.1, 1.3);
      agent.range_at_departure_m = std::min(agent.range_at_departure_m, agent.range_full_m);
      if (agent.online(situation.now_us)) agents->push_back(agent);
    }
  };
  add(AgentKind::kUav, &situation.uavs);
  add(AgentKind::kWorker, &situation.workers);
  add(AgentKind::kVehicle, &situation.vehicles);
  for (std::size_t x = 0; x < scenario.tasks.size(); ++x) {
    situation.task_status.push_back(random.Uniform() < done ? TaskStatus::kDone
                                                            : TaskStatus::kOpen);
  }
  situation.charging_load.assign(scenario.charging_points.size(), 0);
  return situation;
}

}  // namespace muster::scheduler::testing
