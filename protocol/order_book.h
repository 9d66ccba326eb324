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

/// The orders that a mission has taken, and its scenario as the orders have changed it. Every
/// process and every reader of a log keeps one. The orders of a tick may arrive in any order and
/// repeatedly. After a restart of the world they may differ; then those of the later start count.
class OrderBook {
 public:
  explicit OrderBook(const Scenario& scenario);
  OrderBook(const OrderBook&) = delete;
  OrderBook& operator=(const OrderBook&) = delete;
  OrderBook(OrderBook&&) = default;
  OrderBook& operator=(OrderBook&&) = default;

  /// The scenario with all orders up to tick(). The object stays the same; it changes in place.
  const std::shared_ptr<const Scenario>& scenario() const { return view_; }

  /// Takes the world's orders_t of one tick. False: it is impossible, and nothing is taken.
  bool Take(const orders_t& orders);
  /// Takes what another process has heard so far, where that is more, or `anyhow`. False: as above.
  bool Take(const order_book_t& book, bool anyhow = false);

  bool takes_orders() const { return takes_orders_; }
  /// Whether all orders taken up to and including that tick are known. Always true in a mission
  /// that takes no orders.
  bool complete(std::int64_t tick) const { return !takes_orders_ || tick <= tick_; }
  /// The same, and that tick's orders are of the world's start `boot_id` or a later one.
  bool complete(std::int64_t tick, std::int64_t boot_id) const;
  /// The last tick up to which it is complete; -1: none.
  std::int64_t tick() const { return tick_; }
  std::span<const TakenOrder> TakenAt(std::int64_t tick) const;
  /// Whether an order of that id was taken or refused.
  bool knows(const std::string& id) const { return ids_.contains(id); }
  /// Orders taken and refused so far.
  std::int64_t size() const { return n_; }
  /// The world's orders_t of a tick up to tick().
  orders_t SaidAt(std::int64_t tick) const;
  /// Each orders_t, by tick; some without orders are left out.
  const std::map<std::int64_t, orders_t>& said() const { return said_; }
  /// The book as it stood at that tick.
  OrderBook UpTo(std::int64_t tick) const;
  /// All orders, for a process that lacks them. The header is not filled.
  order_book_t ToWire() const;
  /// Counts changes of the scenario.
  std::int64_t version() const { return version_; }

 private:
  /// Adds them to the scenario; false: they are impossible, and the scenario must go back.
  bool Read(const orders_t& orders);
  /// Forgets what came after that tick, and reads all orders before it again.
  void GoBack(std::int64_t tick);
  /// Reads up to the first tick whose orders are missing.
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
