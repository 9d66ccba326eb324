#pragma once

#include <cstdint>
#include <map>
#include <muster/order_t.hpp>
#include <muster/orders_t.hpp>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/check.h"
#include "world/planned_orders.h"

namespace muster::tools {

/// {"id", "error": why}, with the order's id if it can be read and has one.
std::string ErrorText(const InputError& error, const std::string& order);

/// Where orders from outside meet the launcher, which says them in the mission and hears what
/// became of them. Any thread gives and asks; one takes and answers.
class OrderGate {
 public:
  explicit OrderGate(std::optional<Origin> origin) : origin_(origin) {}

  /// Reads an order (ReadOrder) and hands it on. Returns its id. Throws InputError. With the id of
  /// an earlier one it is that one.
  std::string Give(const std::string& json, const std::string& issuer);

  /// What became of it, as JSON: {"id", "taken": {"tick", "sim_s", "task" | "agent"}},
  /// {"id", "refused": reason}, or, when the mission has ended without an answer, {"id", "error"}.
  /// None: there is no such order, or nothing is known yet.
  std::optional<std::string> AnswerTo(const std::string& id) const;
  bool knows(const std::string& id) const;

  /// Those that have been given since; headers are not filled.
  std::vector<order_t> Take();
  void Answer(const orders_t& orders);
  /// Nothing is answered any more.
  void Close();

 private:
  const std::optional<Origin> origin_;
  mutable std::mutex mutex_;
  std::vector<order_t> given_;
  std::map<std::string, std::string> answers_;  ///< by id; "": none yet
  bool closed_ = false;
};

}  // namespace muster::tools
