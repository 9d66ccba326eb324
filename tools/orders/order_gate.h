#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <muster/order_t.hpp>
#include <muster/orders_t.hpp>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/check.h"
#include "tools/orders/persons_desk.h"
#include "world/planned_orders.h"

namespace muster::tools {

/// {"id", "error": why}, with the order's id if it can be read and has one.
std::string ErrorText(const InputError& error, const std::string& order);

/// {"id", "refused": why}, in the same way.
std::string RefusalText(const NotAllowed& refusal, const std::string& order);

/// Where orders from outside meet the launcher, which says them in the mission and hears what
/// became of them. Any thread gives and asks; one takes and answers.
class OrderGate {
 public:
  /// `persons`: who may order; null: everybody who reaches the gate.
  explicit OrderGate(std::optional<Origin> origin, PersonsDesk* persons = nullptr)
      : origin_(origin), persons_(persons) {}

  /// Reads an order (ReadOrder) and hands it on. Returns its id. `issuer`: of an order that names
  /// none; `token`: what its giver has shown, "": nothing. Throws InputError, and NotAllowed where
  /// persons are known and this is none of them. With the id of an earlier one it is that one.
  std::string Give(const std::string& json, const std::string& issuer, std::string_view token);
  bool has_persons() const { return persons_ != nullptr; }
  /// Whether a person has that token.
  bool KnowsToken(std::string_view token) const;

  /// What became of it, as JSON: {"id", "taken": {"tick", "sim_s", "task" | "agent"}},
  /// {"id", "refused": reason}, or, when the mission has ended without an answer, {"id", "error"}.
  /// None: there is no such order, or nothing is known yet.
  std::optional<std::string> AnswerTo(const std::string& id) const;
  bool knows(const std::string& id) const;

  /// Those that have been given since, and what has changed of the persons; headers are not filled.
  std::vector<order_t> Take(std::int64_t wall_us);
  void Answer(const orders_t& orders);
  /// Nothing is answered any more.
  void Close();

 private:
  /// Puts the proof of who gave the order into it. Throws NotAllowed.
  void Prove(const SignedOrder& given, std::string_view token, world::PlannedOrder* order);

  const std::optional<Origin> origin_;
  PersonsDesk* const persons_;
  mutable std::mutex mutex_;
  std::vector<order_t> given_;
  std::map<std::string, std::string> answers_;  ///< by id; "": none yet
  bool closed_ = false;
  std::chrono::steady_clock::time_point quiet_until_{};  ///< of what is said of those turned away
};

}  // namespace muster::tools
