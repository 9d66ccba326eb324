#pragma once

#include <nlohmann/json.hpp>

#include "protocol/order_book.h"

namespace muster::tools {

/// What the commander has decided, in the order of the orders: [from_ms, until_ms (null: still in
/// force), order, issuer, kind, words, uav, worker, vehicle, task] each; -1: not named.
nlohmann::ordered_json DirectiveRows(const OrderBook& orders);

}  // namespace muster::tools
