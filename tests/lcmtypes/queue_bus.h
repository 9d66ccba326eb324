#pragma once

#include <utility>
#include <vector>

#include "lcmtypes/bus/bus.h"

namespace muster::testing {

/// A bus whose two ends are in the test's hands.
class QueueBus : public Bus {
 public:
  void Publish(const Packet& packet) override { sent.push_back(packet); }
  std::vector<Packet> Receive(std::int64_t /*timeout_us*/) override {
    return std::exchange(arriving, {});
  }

  std::vector<Packet> arriving;  ///< to be received next
  std::vector<Packet> sent;
};

}  // namespace muster::testing
