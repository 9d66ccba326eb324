#include "world/planned_orders.h"

#include <fmt/format.h>

#include <fstream>

#include "base/check.h"

namespace muster::world {

std::vector<PlannedOrder> ReadPlannedOrders(const std::string& file) {
  std::ifstream in(file);
  if (!in.is_open()) throw SystemError(fmt::format("cannot read {}", file));
  std::vector<PlannedOrder> orders;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    const std::string where = fmt::format("{}: line {}", file, number);
    Order order = ParseOrder(line, where);
    if (order.id.empty()) throw InputError(where, "id", "no such key", "an id");
    orders.push_back({std::move(order), line});
  }
  return orders;
}

}  // namespace muster::world
