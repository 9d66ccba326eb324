#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "simulation/virtual_network.h"

namespace muster::simulation {

/// lcm-logger on a virtual network, as `muster run` starts it (--flush-interval=1): it loses
/// nothing on the way, and writes to the disk what it holds when a message arrives later than the
/// flush interval after the last time. Destroying it is SIGKILL: what it holds is lost.
class VirtualLogger : private Participant {
 public:
  /// One event of the log; received_us: virtual time.
  struct Event {
    TimeUs received_us = 0;
    SentPacket packet;
  };

  /// Appends to `file` what reaches the disk; it must outlive this object.
  VirtualLogger(VirtualNetwork* network, std::vector<Event>* file);
  ~VirtualLogger() override;
  VirtualLogger(const VirtualLogger&) = delete;
  VirtualLogger& operator=(const VirtualLogger&) = delete;

  /// SIGSTOP: what arrives waits in its socket. SIGCONT.
  void set_stopped(bool stopped);
  bool stopped() const { return stopped_; }
  /// The disk takes no further byte, or does again.
  void set_disk_full(bool full) { disk_full_ = full; }
  /// It has tried to write to the full disk (SIGXFSZ); it does nothing any more.
  bool died() const { return died_; }
  /// SIGTERM: writes what it holds.
  void End() { Flush(); }

 private:
  void OnArrival(const SentPacket& packet) override;
  TimeUs wake_us() const override { return kNever; }
  void Wake() override {}
  void Log(const SentPacket& packet);
  void Flush();

  VirtualNetwork* network_;
  std::vector<Event>* file_;
  std::vector<Event> held_;  ///< not on the disk yet
  VirtualSocket socket_;     ///< while stopped
  TimeUs flushed_us_;
  bool stopped_ = false;
  bool disk_full_ = false;
  bool died_ = false;
};

}  // namespace muster::simulation
