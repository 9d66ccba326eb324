#pragma once

#include <string>
#include <vector>

#include "model/action.h"
#include "model/road_area.h"
#include "model/scenario.h"
#include "world/referee.h"

namespace muster::world {

/// Roads that a fault closes for some time. Nobody knows until an agent stands before them, or
/// somebody tells (kToldAfterUs). The world then closes them by an order.
struct HiddenClosure {
  RoadArea area;
  TimeUs from_us = 0;
  TimeUs until_us = kNever;
  std::string fault;  ///< its id
};

/// What faults do in the world.
struct WorldFaults {
  std::vector<Outage> outages = {};
  std::vector<HiddenClosure> closures = {};
};

inline constexpr TimeUs kToldAfterUs = 10 * kMinuteUs;

/// The commands that the agents have been given at that time.
struct Commands {
  const std::vector<Action>& actions;
  std::int32_t decision = -1;
  TimeUs at_us = 0;
};

/// Whether it is known at t that those roads are closed. `agents`: as they were judged to be when
/// the commands were given.
bool IsToldOrMet(const HiddenClosure& closure, TimeUs t, const Scenario& scenario,
                 const Agents& agents, const Commands& commands);

std::string OrderIdOf(const HiddenClosure& closure);
/// The order, as JSON.
std::string OrderToClose(const HiddenClosure& closure, TimeUs t, const Rules& rules);

}  // namespace muster::world
