#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <muster/order_book_t.hpp>
#include <muster/orders_t.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "model/order.h"
#include "protocol/sender.h"

namespace muster {

/// The orders that a mission has taken, and its scenario as they have made it. A mission is its
/// scenario and these; every process and every reader of a log keeps one. What is taken may be
/// heard in any order, again, and after a restart of the world once more of the same tick: then the
/// later start's word counts.
class OrderBook {
 public:
  explicit OrderBook(const Scenario& scenario);
  OrderBook(const OrderBook&) = delete;
  OrderBook& operator=(const OrderBook&) = delete;
  OrderBook(OrderBook&&) = default;
  OrderBook& operator=(OrderBook&&) = default;

  /// The scenario with all orders up to tick(). The object stays the same; it changes in place.
  const std::shared_ptr<const Scenario>& scenario() const { return view_; }

  /// Takes what the world said of one tick. False: it cannot be, and nothing is taken.
  bool Take(const orders_t& orders);
  /// What somebody else has heard so far.
  bool Take(const order_book_t& book);

  bool takes_orders() const { return takes_orders_; }
  /// Whether all that was taken up to and with that tick is known. Always, in a mission that takes
  /// no orders.
  bool complete(std::int64_t tick) const { return !takes_orders_ || tick <= tick_; }
  /// The same, and none of that tick is an earlier start's word than `boot_id`.
  bool complete(std::int64_t tick, std::int64_t boot_id) const;
  /// Up to and with which tick it is complete; -1: none.
  std::int64_t tick() const { return tick_; }
  std::span<const TakenOrder> TakenAt(std::int64_t tick) const;
  /// Whether an order of that id was taken or refused.
  bool knows(const std::string& id) const { return ids_.contains(id); }
  /// Orders taken and refused so far.
  std::int64_t size() const { return n_; }
  /// What the world said of a tick up to tick().
  orders_t SaidAt(std::int64_t tick) const;
  /// What was said, by tick; some without orders are left out.
  const std::map<std::int64_t, orders_t>& said() const { return said_; }
  /// The book as it stood at that tick.
  OrderBook UpTo(std::int64_t tick) const;
  /// All orders, for a process that lacks them. The header is not filled.
  order_book_t ToWire() const;
  /// Counts changes of the scenario.
  std::int64_t version() const { return version_; }

 private:
  /// Adds it to the scenario; false: it cannot be, and the scenario must go back.
  bool Read(const orders_t& orders);
  /// Forgets what came after that tick, and reads all before again.
  void GoBack(std::int64_t tick);
  /// Reads as far as nothing lacks.
  bool GoOn();

  bool takes_orders_;
  std::optional<Scenario> base_;  ///< before any order; none: no orders are taken
  std::shared_ptr<Scenario> scenario_;
  std::shared_ptr<const Scenario> view_;
  std::map<std::int64_t, orders_t> said_;  ///< by tick
  std::map<std::int64_t, std::vector<TakenOrder>> taken_;
  std::set<std::string> ids_;
  std::int64_t n_ = 0;      ///< orders up to tick_
  std::int64_t tick_ = -1;  ///< everything is known and read up to that one
  std::int64_t version_ = 0;
};

/// The book as an answer_t carries it.
std::vector<std::uint8_t> BookBytes(const OrderBook& book, const Identity& sender);

/// The order as the world says it was taken.
taken_order_t ToWire(const TakenOrder& taken, std::string json);

}  // namespace muster
