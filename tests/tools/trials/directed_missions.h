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

inline void DrawDirectives(std::uint64_t seed, VirtualMission* mission) {
  Random random(seed, Stream::kTest, 3);
  for (world::PlannedOrder& order : DrawDirectives(mission->scenario, &random)) {
    mission->orders.push_back(std::move(order));
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
