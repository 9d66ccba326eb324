#pragma once

#include <memory>
#include <muster/clock_t.hpp>
#include <optional>
#include <string_view>

#include "model/scenario.h"
#include "protocol/order_book.h"
#include "protocol/process.h"
#include "protocol/scenario_reader.h"

namespace muster {

/// So many messages of an earlier start of the world, and none of the later one: its number was
/// damaged on the way, and nobody has that number.
constexpr int kMostOutdated = 20;

/// A participant that follows the world's clock. It asks for the scenario until it has one, and
/// only then hears anything else.
class Follower : public Process {
 public:
  using Process::Process;

 protected:
  /// Once, when scenario() has come.
  virtual void OnScenario() = 0;
  /// As OnMessage and OnStep, with a scenario.
  virtual void OnMissionMessage(const Message& message, const Packet& packet, const Now& now) = 0;
  virtual void OnMissionStep(const Now& now) = 0;

  /// With the orders that this process has heard of; it changes in place.
  const std::shared_ptr<const Scenario>& scenario() const { return book_->scenario(); }
  /// With a scenario.
  const OrderBook& orders() const { return *book_; }
  /// Whether all orders up to that tick are known; if not, asks for them. `boot_id`: the world's
  /// start that published that tick.
  bool HasOrders(std::int64_t tick, std::int64_t boot_id, const Now& now);

  /// Goes from ready to running to ended as the clock says.
  void Follow(const clock_t& clock);

  /// Requests what that channel carries, again and again while it is called.
  void Ask(std::string_view channel, TimeUs sim_us, const Now& now);
  /// Unless it has to doubt the orders that it has heard: then it asks for them.
  void AskNoMore(const Now& now);
  /// Counts a message that is impossible in the light of scenario().
  void Reject();

  TimeUs OwnWakeUs() const override { return request_.due_us(); }

 private:
  /// So much of what it hears is impossible that it may have heard orders damaged.
  bool DoubtsOrders() const;
  /// Whether the message was about orders alone.
  bool TakeOrders(const Message& message, const Now& now);
  void OnMessage(const Message& message, const Packet& packet, const Now& now) final;
  void OnStep(const Now& now) final;

  ScenarioReader scenario_reader_;  ///< until there is a book
  std::optional<OrderBook> book_;
  TimeUs lacks_orders_since_us_ = kNever;
  std::int64_t lacked_tick_ = -1;  ///< whose they are
  int n_impossible_ = 0;           ///< messages since all orders were last told
  BackOff request_{5'000, 200'000};
};

}  // namespace muster
