#pragma once

#include <string>
#include <vector>

#include "model/order.h"

namespace muster::world {

/// An order that is given with the mission, before it begins.
struct PlannedOrder {
  Order order;
  std::string json;
};

/// Reads them, a line each, in the wire's form (docs/guide/orders.md): every one has an id. Throws
/// InputError, SystemError.
std::vector<PlannedOrder> ReadPlannedOrders(const std::string& file);

}  // namespace muster::world
