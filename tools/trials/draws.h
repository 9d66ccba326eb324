#pragma once

#include <vector>

#include "base/random.h"
#include "tools/simulate/virtual_mission.h"

namespace muster::tools {

/// Orders of all kinds but directives, roads and zones, possible or not: tasks are added, changed,
/// held and cancelled, agents join, leave and are recalled.
std::vector<world::PlannedOrder> DrawTaskOrders(const Scenario& scenario, Random* random);

/// Pins, forbidden pairs and areas, charges, places to wait at; some are ended again.
std::vector<world::PlannedOrder> DrawDirectives(const Scenario& scenario, Random* random);

/// Roads of the scenario are closed: as planned, by order, and unknown to all.
void DrawClosures(Random* random, VirtualMission* mission);

/// Zones: concave, touching, with holes; for the whole mission, for a time, by order, lifted.
void DrawZones(Random* random, VirtualMission* mission);

/// Zones of which nobody knows at first, where the scenario has zones or takes them.
void DrawLateZones(std::uint64_t seed, VirtualMission* mission);

/// Streets for people and vehicles. Some agents never leave them, others cross open ground.
void DrawStreets(std::uint64_t seed, Scenario* scenario);

}  // namespace muster::tools
