#include "world/planned_orders.h"

#include <fmt/format.h>

#include <sstream>

#include "base/check.h"
#include "base/text_file.h"

namespace muster::world {

std::vector<PlannedOrder> ReadPlannedOrders(const std::string& file) {
  std::istringstream in(ReadTextFile(file, "orders"));
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
