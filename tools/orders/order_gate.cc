#include "tools/orders/order_gate.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "base/json_tree.h"
#include "base/say.h"
#include "base/text.h"
#include "base/units.h"
#include "lcmtypes/words.h"
#include "tools/scenario/order_text.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostOrders = 1'000'000;
constexpr const char* kEnded = "the mission has ended";
constexpr std::chrono::seconds kQuiet{1};

/// {"id", key: why}, with the order's id if it can be read and has one.
std::string WithId(const std::string& order, const char* key, const char* why) {
  Json json;
  try {
    const JsonValue given = ParseJson(order, "");
    const JsonValue* id = given.Find("id");
    if (id != nullptr && id->type == JsonValue::Type::kString) json["id"] = id->text;
  } catch (const InputError&) {
    // Its error is the one that is told.
  }
  json[key] = why;
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// The order without "signed", which is read into `given`. Throws InputError.
std::string TakeSignature(const std::string& json, SignedOrder* given) {
  Json order = Json::parse(json, nullptr, false);
  if (!order.is_object() || !order.contains("signed")) return json;
  const Json& proof = order["signed"];
  const auto text = [&](const char* key) -> std::string {
    if (!proof.is_object() || !proof.contains(key) || !proof[key].is_string()) {
      throw InputError("order", fmt::format("signed.{}", key), "no such text",
                       "a name (by) and a signature of 128 hexadecimal digits (signature)");
    }
    return proof[key].get<std::string>();
  };
  given->by = text("by");
  given->signature = text("signature");
  order.erase("signed");
  return order.dump();
}

}  // namespace

std::string ErrorText(const InputError& error, const std::string& order) {
  return WithId(order, "error", error.what());
}

std::string RefusalText(const NotAllowed& refusal, const std::string& order) {
  return WithId(order, "refused", refusal.what());
}

std::string OrderGate::Give(const std::string& json, const std::string& issuer,
                            std::string_view token) {
  SignedOrder given;
  world::PlannedOrder planned = ReadOrder(TakeSignature(json, &given), "order", origin_);
  if (!given.by.empty() && persons_ == nullptr) {
    throw InputError("order", "signed", given.by,
                     "no signature: the mission was started without --persons");
  }
  const std::lock_guard lock(mutex_);
  if (persons_ != nullptr) {
    Prove(given, token, &planned);
  } else if (planned.order.issuer.empty()) {
    planned.order.issuer = issuer;
  }
  order_t order{};
  order.id = planned.order.id;
  order.issuer = planned.order.issuer;
  order.json = planned.json;
  if (answers_.size() >= kMostOrders) {
    throw InputError(fmt::format("order: more than {} in one mission", kMostOrders));
  }
  if (answers_.try_emplace(order.id, "").second) given_.push_back(order);
  return order.id;
}

void OrderGate::Prove(const SignedOrder& given, std::string_view token,
                      world::PlannedOrder* order) {
  try {
    persons_->Prove(given, token, order);
  } catch (const NotAllowed& refusal) {
    const auto now = std::chrono::steady_clock::now();
    if (now >= quiet_until_) {
      const std::string& issuer = order->order.issuer;
      Say("muster: order {}{} is refused: {}\n", Printable(order->order.id),
          issuer.empty() ? "" : " of " + Printable(issuer), Printable(refusal.what()));
      quiet_until_ = now + kQuiet;
    }
    throw;
  }
}

bool OrderGate::KnowsToken(std::string_view token) const {
  const std::lock_guard lock(mutex_);
  return persons_ != nullptr && persons_->OfToken(token) != nullptr;
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

std::vector<order_t> OrderGate::Take(std::int64_t wall_us) {
  const std::lock_guard lock(mutex_);
  std::vector<order_t> orders = std::exchange(given_, {});
  if (persons_ != nullptr) {
    for (order_t& order : persons_->Changes(wall_us)) orders.push_back(std::move(order));
  }
  return orders;
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
