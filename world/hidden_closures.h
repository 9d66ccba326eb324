#pragma once

#include <string>
#include <variant>
#include <vector>

#include "lcmtypes/words.h"
#include "model/action.h"
#include "model/road_area.h"
#include "model/scenario.h"
#include "model/zone.h"
#include "world/referee.h"

namespace muster::world {

/// Roads that a fault closes, or a zone that it makes, for some time. Nobody knows until an agent
/// comes there, or somebody tells (kToldAfterUs). The world then says so by an order.
struct HiddenClosure {
  std::variant<RoadArea, Zone> of;
  TimeUs from_us = 0;
  TimeUs until_us = kNever;
  std::string fault;  ///< its id
};

/// That of a fault on roads or air in a circle.
HiddenClosure HiddenIn(FaultKind kind, const RoadArea& circle, TimeUs from_us, TimeUs until_us,
                       std::string fault);

/// What faults do in the world.
struct WorldFaults {
  std::vector<Outage> outages = {};
  std::vector<HiddenClosure> closures = {};
};

inline constexpr TimeUs kToldAfterUs = 10 * kMinuteUs;

/// Whether the scenario has such ways at all.
bool IsPossible(const HiddenClosure& closure, const Scenario& scenario);

/// The commands that the agents have been given at that time.
struct Commands {
  const std::vector<Action>& actions;
  std::int32_t decision = -1;
  TimeUs at_us = 0;
};

/// Whether those roads are known to be closed at t, or that zone to be one. `agents`: as they were
/// judged to be when the commands were given.
bool IsToldOrMet(const HiddenClosure& closure, TimeUs t, const Scenario& scenario,
                 const Agents& agents, const Commands& commands);

std::string OrderIdOf(const HiddenClosure& closure);
/// The order by which it becomes known, as JSON.
std::string OrderOf(const HiddenClosure& closure, TimeUs t, const Rules& rules);

}  // namespace muster::world
