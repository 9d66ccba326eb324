#pragma once

#include <cstdint>
#include <map>
#include <muster/order_t.hpp>
#include <muster/orders_t.hpp>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "protocol/order_book.h"
#include "world/planned_orders.h"
#include "world/referee.h"

namespace muster::world {

/// Takes orders or refuses them with a reason: each id once, and all of a tick together. An order
/// that its giver withdraws before or at its tick is refused.
class OrderDesk {
 public:
  /// `planned`, and the scenario's planned closures of roads, are taken at the first tick that is
  /// not before their time.
  OrderDesk(const Scenario& scenario, std::vector<PlannedOrder> planned);

  const OrderBook& book() const { return book_; }
  const Scenario& scenario() const { return *book_.scenario(); }

  /// Whether the order may be heard: the mission knows no persons, or one of them has signed it for
  /// this run. What role they have is decided on at the tick.
  bool Admits(const order_t& order, std::int64_t run_id) const;
  /// Keeps it for the next tick. False: it was answered already, at tick AnsweredAt().
  bool Hear(const order_t& order);
  /// -1: it was not.
  std::int64_t AnsweredAt(const std::string& id) const;
  /// Gives an order of the world's own. The second one of that id is not heard.
  void Give(const std::string& id, std::string json);
  /// Ends the directives that the event fulfils, or leaves nothing to do for.
  void EndFulfilled(const Event& event);
  /// Asks for a decision at the next tick if the event leaves an emergency open, and the rules say
  /// so.
  void DecideIfReopened(const Event& event);
  /// Plans an order of the world's own: to do that task again, its revisit time after `done_us`.
  void Revisit(TaskId task, TimeUs done_us);

  /// Decides at tick `tick` on the orders heard so far, with the states of tasks and agents after
  /// the tick before. If an earlier start of the world has decided on that tick, its decision
  /// stands. The caller fills the header and then calls Take() with the result.
  orders_t Decide(std::int64_t tick, std::span<const TaskStatus> status, const Agents& agents);
  /// Takes what the world has published, or what another process has heard from an earlier start.
  void Take(const orders_t& orders);
  bool Take(const order_book_t& book);

  static constexpr std::size_t kMostWaiting = 100'000;  ///< more are not heard for now
  static constexpr std::size_t kMostBytes = 1 << 20;    ///< of a tick's orders

 private:
  struct Waiting {
    std::string id, issuer, json;
    bool withdraws = false;
  };
  /// Plans the opening of roads that the order closes for a time.
  void PlanOpening(const TakenOrder& taken, TimeUs t);
  /// What follows later from an order that was taken at that tick.
  void Note(const TakenOrder& taken, std::int64_t tick);
  /// Throws InputError where the order that it names is answered, or somebody else's.
  void CheckWithdrawal(const Order& withdrawal, const orders_t& said) const;
  /// The order's id and its giver, where the mission knows its persons: each withdraws their own.
  std::pair<std::string, std::string> Own(const std::string& id, const Order& given) const;
  void DecideOn(const Waiting& waiting, TimeUs t, std::span<const TaskStatus> status,
                const Agents& agents, Scenario* scenario, orders_t* said);

  OrderBook book_;
  bool has_persons_;                   ///< the mission was started with some
  std::vector<PlannedOrder> planned_;  ///< latest first
  std::vector<Waiting> waiting_;       ///< withdrawals, then others, each in order of arrival
  std::set<std::string> waiting_ids_;
  std::map<std::string, std::int64_t> answered_;  ///< ticks, by id
  /// Ids of those that were taken, by Own() of the order that they withdraw.
  std::map<std::pair<std::string, std::string>, std::string> withdrawals_;
};

}  // namespace muster::world
