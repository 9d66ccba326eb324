#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "lcmtypes/bus/lossy_bus.h"
#include "protocol/drive.h"
#include "protocol/process.h"
#include "simulation/virtual_network.h"

namespace muster::simulation {

/// A process's core on a virtual network, as RunProcess() drives it over LCM: it hears through a
/// lossy bus of its own, applies the faults that MUSTER_FAULT orders, sends heartbeats. Steps take
/// no time. Destroying it is SIGKILL.
class VirtualProcess : private Participant {
 public:
  /// `seed`: of what becomes of its packets, as LossyBus's; `faults`: from the start; `wall_us`:
  /// its host's clock, since the Unix epoch; null: that of the network.
  VirtualProcess(VirtualNetwork* network, std::unique_ptr<Process> core, std::uint64_t seed,
                 const PacketFaults& faults = {}, std::function<TimeUs()> wall_us = {});
  ~VirtualProcess() override;
  VirtualProcess(const VirtualProcess&) = delete;
  VirtualProcess& operator=(const VirtualProcess&) = delete;

  /// SIGSTOP: it neither steps nor hears; what arrives waits in its socket. SIGCONT.
  void set_stopped(bool stopped) { stopped_ = stopped; }
  bool stopped() const { return stopped_; }

  /// What was wrong with its mission, when it has ended of that: it does nothing any more.
  const std::string& failure() const { return failure_; }

  const std::string& name() const { return core_->identity().name; }
  Process& core() { return *core_; }
  LossyBus& bus() { return *bus_; }

 private:
  void OnArrival(const SentPacket& packet) override { socket_->Enqueue(packet); }
  TimeUs wake_us() const override;
  void Wake() override;

  VirtualNetwork* network_;
  std::function<TimeUs()> wall_us_;
  std::unique_ptr<Process> core_;
  VirtualSocket* socket_;  ///< owned by bus_
  std::unique_ptr<LossyBus> bus_;
  Drive drive_;
  TimeUs turn_us_ = 0;  ///< the latest time of the next turn
  bool stopped_ = false;
  std::string failure_;
};

}  // namespace muster::simulation
