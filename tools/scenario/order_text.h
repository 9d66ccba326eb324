#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/scenario.h"
#include "world/planned_orders.h"

namespace muster::tools {

/// An order as people and other programs write it, made ready for the mission: a place given as
/// latitude_deg and longitude_deg becomes x_km and y_km by the scenario's origin. `id` and `issuer`
/// go where messages have them; without an id the order gets one that nobody else has. Throws
/// InputError naming `where`, key, value and what was expected.
world::PlannedOrder ReadOrder(std::string_view json, const std::string& where,
                              const std::optional<Origin>& origin);

/// Orders from a file, "-": from stdin, a line each. Empty lines are passed over.
std::vector<world::PlannedOrder> ReadOrderFile(const std::string& file,
                                               const std::optional<Origin>& origin);

/// A line each, for the world.
std::string OrderLines(const std::vector<world::PlannedOrder>& orders);

/// Room for the tasks and agents that these add.
Room RoomFor(const std::vector<world::PlannedOrder>& orders);

/// An id that no other order has.
std::string FreshOrderId();

}  // namespace muster::tools
