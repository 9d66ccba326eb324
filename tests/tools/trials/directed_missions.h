#ifndef MUSTER_TESTS_TOOLS_TRIALS_DIRECTED_MISSIONS_H_
#define MUSTER_TESTS_TOOLS_TRIALS_DIRECTED_MISSIONS_H_

#include <fmt/format.h>

#include <cstdint>
#include <iterator>
#include <string>
#include <vector>

#include "base/random.h"
#include "model/order.h"
#include "tests/tools/trials/air_missions.h"

namespace muster::tools {

/// Pins, forbidden pairs and areas, charges, places to wait at; some are ended again.
inline void DrawDirectives(std::uint64_t seed, VirtualMission* mission) {
  Random random(seed, Stream::kTest, 3);
  const Scenario& scenario = mission->scenario;
  const auto agent = [&](AgentKind kind) {
    const auto n = static_cast<std::uint32_t>(scenario.agents(kind).size());
    return fmt::format("{}:{}", ToString(kind), random.Below(n));
  };
  const auto any = [&] { return kAgentKinds[random.Below(3)]; };
  const auto km = [&](double metres) { return random.Uniform(0, metres / 1000); };
  const auto task = [&] { return random.Below(static_cast<std::uint32_t>(scenario.tasks.size())); };
  const auto add = [&](std::uint32_t minute, const std::string& id, const std::string& rest) {
    const std::string json =
        fmt::format("{{\"id\": \"{}\", \"at_min\": {}, {}}}", id, minute, rest);
    mission->orders.push_back({ParseOrder(json, "order"), json});
  };
  const std::uint32_t n = 5 + random.Below(20);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t minute = random.Below(85);
    const std::string id = fmt::format("d{}", i);
    switch (random.Below(6)) {
      case 0:
      case 1: {
        std::string names;
        const std::uint32_t who = random.Below(3);
        if (who != 1) names += fmt::format("\"{}\"", agent(AgentKind::kUav));
        if (who == 2) names += ", ";
        if (who != 0) names += fmt::format("\"{}\"", agent(AgentKind::kWorker));
        add(minute, id,
            fmt::format("\"order\": \"pin\", \"task\": {}, \"agents\": [{}]", task(), names));
        break;
      }
      case 2:
        add(minute, id,
            fmt::format("\"order\": \"forbid\", \"task\": {}, \"agent\": \"{}\"", task(),
                        agent(random.Below(2) == 0 ? AgentKind::kUav : AgentKind::kWorker)));
        break;
      case 3:
        add(minute, id,
            fmt::format(
                "\"order\": \"charge_now\", \"agents\": [\"{}\"{}]", agent(AgentKind::kUav),
                random.Below(2) == 0 ? fmt::format(", \"{}\"", agent(AgentKind::kVehicle)) : ""));
        break;
      case 4:
        add(minute, id,
            fmt::format(
                "\"order\": \"go_to\", \"agent\": \"{}\", \"x_km\": {:.3f}, \"y_km\": {:.3f}",
                agent(any()), km(scenario.width_m), km(scenario.height_m)));
        break;
      default:
        add(minute, id,
            fmt::format(
                "\"order\": \"forbid\", \"class\": \"{}\", \"circle_km\": [{:.3f}, {:.3f}, 2]",
                ToString(any()), km(scenario.width_m), km(scenario.height_m)));
    }
    if (random.Below(3) == 0) {
      add(minute + random.Below(40), "r" + id,
          fmt::format("\"order\": \"release\", \"directive\": \"{}\"", id));
    }
  }
}

/// A third of Random_1 with zones or roads, and directives.
inline VirtualMission DirectedMission(const std::string& policy, std::uint64_t seed) {
  VirtualMission mission = AirMission(policy, seed);
  DrawDirectives(seed, &mission);
  return mission;
}

/// The same with kills, loss and a policy that are drawn.
inline VirtualMission DrawDirectedMission(std::uint64_t seed) {
  VirtualMission mission = DrawAirMission(seed);
  DrawDirectives(seed, &mission);
  return mission;
}

}  // namespace muster::tools

#endif  // MUSTER_TESTS_TOOLS_TRIALS_DIRECTED_MISSIONS_H_
