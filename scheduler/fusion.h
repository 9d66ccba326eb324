#pragma once

#include <memory>
#include <muster/agent_states_t.hpp>
#include <muster/rulings_t.hpp>
#include <muster/world_state_t.hpp>
#include <optional>
#include <vector>

#include "protocol/convert.h"
#include "protocol/order_book.h"
#include "scheduler/situation.h"

namespace muster::scheduler {

/// Collects the messages of one tick until they are complete: every agent's state, the world's
/// state and its rulings. The state of an agent that has failed by a ruling may be missing.
/// Messages may come in any order and repeatedly.
class Fusion {
 public:
  explicit Fusion(const std::shared_ptr<const Scenario>& scenario);

  /// Forgets everything and collects for a decision at `tick`, time t.
  void Start(std::int64_t tick, TimeUs t, std::int32_t decision);

  /// False if anything in the message is impossible; then nothing of it is taken.
  bool Take(const agent_states_t& states);
  bool Take(const world_state_t& world);
  bool Take(const rulings_t& rulings);

  bool complete() const { return activities_ && rulings_ && missing_ <= silent(); }
  /// The situation with the orders up to that tick; only when complete.
  Situation Fuse(const OrderBook& orders);

 private:
  /// Agents without a state that have failed.
  std::size_t silent() const;

  const std::shared_ptr<const Scenario> held_;
  const Scenario& scenario_;
  const WireLimits limits_;
  std::shared_ptr<const Site> site_;
  std::int64_t site_version_ = 0;  ///< of the orders; -1: it is of none that may come again
  std::int64_t tick_ = -1;
  TimeUs now_us_ = 0;
  std::int32_t decision_ = -1;
  std::size_t missing_ = 0;
  PerKind<std::vector<std::optional<AgentState>>> agents_;
  std::optional<std::vector<Activity>> activities_;
  std::optional<std::vector<Ruling>> rulings_;
  std::vector<TaskStatus> task_status_;
};

}  // namespace muster::scheduler
