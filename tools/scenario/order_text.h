#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/scenario.h"
#include "world/planned_orders.h"

namespace muster::tools {

/// Reads an order as people and other programs write it. A place given as latitude_deg and
/// longitude_deg becomes x_km and y_km by the scenario's origin. `id` and `issuer` move to the
/// fields that messages have for them; an order without an id gets a new, unique one. Throws
/// InputError naming `where`, key, value and what was expected.
world::PlannedOrder ReadOrder(std::string_view json, const std::string& where,
                              const std::optional<Origin>& origin);

/// Reads orders from a file ("-": from stdin), one per line. Skips empty lines.
std::vector<world::PlannedOrder> ReadOrderFile(const std::string& file,
                                               const std::optional<Origin>& origin);

/// One line per order, for the world.
std::string OrderLines(const std::vector<world::PlannedOrder>& orders);

/// Room for the tasks and agents that these orders add.
Room RoomFor(const std::vector<world::PlannedOrder>& orders);

/// An id that no other order has.
std::string FreshOrderId();

}  // namespace muster::tools
