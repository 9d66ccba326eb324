#include "tools/orders/order_gate.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/json_tree.h"
#include "base/units.h"
#include "lcmtypes/words.h"
#include "tools/scenario/order_text.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostOrders = 1'000'000;
constexpr const char* kEnded = "the mission has ended";

}  // namespace

std::string ErrorText(const InputError& error, const std::string& order) {
  Json json;
  try {
    const JsonValue given = ParseJson(order, "");
    const JsonValue* id = given.Find("id");
    if (id != nullptr && id->type == JsonValue::Type::kString) json["id"] = id->text;
  } catch (const InputError&) {
    // Its error is the one that is told.
  }
  json["error"] = error.what();
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string OrderGate::Give(const std::string& json, const std::string& issuer) {
  const world::PlannedOrder planned = ReadOrder(json, "order", origin_);
  order_t order{};
  order.id = planned.order.id;
  order.issuer = planned.order.issuer.empty() ? issuer : planned.order.issuer;
  order.json = planned.json;
  const std::lock_guard lock(mutex_);
  if (answers_.size() >= kMostOrders) {
    throw InputError(fmt::format("order: more than {} in one mission", kMostOrders));
  }
  if (answers_.try_emplace(order.id, "").second) given_.push_back(order);
  return order.id;
}

bool OrderGate::knows(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  return answers_.contains(id);
}

std::optional<std::string> OrderGate::AnswerTo(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  const auto order = answers_.find(id);
  if (order == answers_.end()) return {};
  if (!order->second.empty()) return order->second;
  if (closed_) return Json{{"id", id}, {"error", kEnded}}.dump();
  return {};
}

std::vector<order_t> OrderGate::Take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(given_, {});
}

void OrderGate::Answer(const orders_t& orders) {
  const std::lock_guard lock(mutex_);
  for (const taken_order_t& order : orders.taken) {
    const auto given = answers_.find(order.id);
    if (given == answers_.end()) continue;
    Json taken = {{"tick", orders.tick}, {"sim_s", ToSeconds(orders.header.sim_us)}};
    if (order.task_id >= 0) taken["task"] = order.task_id;
    if (order.agent_id >= 0) {
      taken["agent"] = fmt::format("{}:{}", ToString<AgentKind>(order.agent_kind), order.agent_id);
    }
    given->second = Json{{"id", order.id}, {"taken", taken}}.dump();
  }
  for (const refused_order_t& order : orders.refused) {
    const auto given = answers_.find(order.id);
    if (given != answers_.end()) {
      given->second = Json{{"id", order.id}, {"refused", order.reason}}.dump();
    }
  }
}

void OrderGate::Close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
}

}  // namespace muster::tools
