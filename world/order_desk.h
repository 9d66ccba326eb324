#pragma once

#include <cstdint>
#include <map>
#include <muster/order_t.hpp>
#include <muster/orders_t.hpp>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "protocol/order_book.h"
#include "world/planned_orders.h"
#include "world/referee.h"

namespace muster::world {

/// Takes orders or refuses them with a reason, each id once, a tick's together.
class OrderDesk {
 public:
  /// `planned` are taken at the first tick that is not before their time.
  OrderDesk(const Scenario& scenario, std::vector<PlannedOrder> planned);

  const OrderBook& book() const { return book_; }
  const Scenario& scenario() const { return *book_.scenario(); }

  /// Keeps it for the next tick. False: it was answered already, at tick AnsweredAt().
  bool Hear(const order_t& order);
  /// -1: it was not.
  std::int64_t AnsweredAt(const std::string& id) const;
  /// An order of the world's own: that task again, when so long has passed since it was done.
  void Revisit(TaskId task, TimeUs done_us);

  /// Decides on what has been heard, as things stand at tick `tick`, with the states of tasks and
  /// agents after the tick before. What an earlier start has said of that tick
  /// stands. The header is not filled; when it is, Take() has to follow.
  orders_t Decide(std::int64_t tick, std::span<const TaskStatus> status, const Agents& agents);
  /// What the world has said, or what somebody else has heard of an earlier start of it.
  void Take(const orders_t& orders);
  bool Take(const order_book_t& book);

  static constexpr std::size_t kMostWaiting = 100'000;  ///< more are not heard for now
  static constexpr std::size_t kMostBytes = 1 << 20;    ///< of a tick's orders

 private:
  struct Waiting {
    std::string id, issuer, json;
  };
  void DecideOn(const Waiting& waiting, TimeUs t, std::span<const TaskStatus> status,
                const Agents& agents, Scenario* scenario, orders_t* said);

  OrderBook book_;
  std::vector<PlannedOrder> planned_;  ///< latest first
  std::vector<Waiting> waiting_;       ///< in order of arrival
  std::set<std::string> waiting_ids_;
  std::map<std::string, std::int64_t> answered_;  ///< ticks, by id
};

}  // namespace muster::world
