#pragma once

#include <cstdint>
#include <muster/event_t.hpp>
#include <muster/rulings_t.hpp>
#include <muster/world_state_t.hpp>

#include "world/referee.h"

namespace muster::world {

/// What the world says of a judged tick; headers are not filled.
event_t ToWire(const Event& event);
world_state_t WorldStateOf(const Referee& referee, std::int64_t tick);
rulings_t RulingsOf(const Verdict& verdict, std::int64_t tick);

}  // namespace muster::world
