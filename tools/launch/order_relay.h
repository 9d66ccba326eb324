#pragma once

#include <map>
#include <muster/orders_t.hpp>
#include <string>

#include "protocol/sender.h"
#include "recorder/recorder.h"
#include "tools/orders/order_gate.h"

namespace muster::tools {

/// Publishes each order that comes through the gate, and repeats it until the log has the world's
/// answer.
class OrderRelay {
 public:
  /// `gate` may be null: there are no orders.
  explicit OrderRelay(OrderGate* gate) : gate_(gate) {}

  void Step(const Now& now, recorder::Recorder* speaker);
  /// Takes a message of the log.
  void OnLogged(const orders_t& orders);
  /// When to step again at the latest.
  TimeUs due_us() const { return open_.empty() ? kNever : again_us_; }

 private:
  OrderGate* const gate_;
  std::map<std::string, SentPacket> open_;  ///< by id
  TimeUs again_us_ = 0;
};

}  // namespace muster::tools
