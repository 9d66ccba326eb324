#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "lcmtypes/bus/lossy_bus.h"
#include "protocol/process.h"
#include "tools/host/child.h"
#include "tools/launch/mission_view.h"

namespace muster::tools {

/// Where a mission's processes and its logger run and its packets go: this host and its network, or
/// virtual time. Processes are known by name; the logger is NameOf(Logger).
class MissionHost {
 public:
  virtual ~MissionHost() = default;

  virtual Now now() const = 0;
  virtual Usage usage() const = 0;
  /// The launcher's own; time may pass, and everything else may happen, while it receives.
  virtual LossyBus& bus() = 0;
  /// The network is back after an outage: processes that do not renew their own sockets need help.
  virtual void OnNetworkBack() {}
  /// How often the user has asked to stop the mission.
  virtual int stops_asked() const = 0;

  /// Starts it for the `starts`-th time after the first. The logger writes to a new file each time.
  virtual void Start(const std::string& name, std::int64_t starts) = 0;
  /// How its latest start ended; none: it has not.
  virtual std::optional<ChildEnd> EndOf(const std::string& name) = 0;
  virtual void Signal(const std::string& name, int signal) = 0;
  /// SIGTERM; one that is stopped is continued first.
  virtual void AskToEnd(const std::string& name) = 0;
  /// Kills it if it still runs.
  virtual void Kill(const std::string& name) = 0;
  virtual bool IsStopped(const std::string& name) const = 0;
  /// The processes of that process's host, itself among them, if the host has a standby; else none.
  virtual std::vector<std::string> OnHostWithStandby(const std::string&) const { return {}; }
  /// From now on they start on the standby. What to say of it.
  virtual std::string MoveToStandby(const std::string&) { return ""; }
  /// The last lines that it wrote, and where they are.
  virtual std::string LastWords(const std::string& name) const = 0;

  /// "": there is room for the log; else the place where there is none.
  virtual std::string NoRoom() const { return ""; }
  /// The log's disk takes no further byte, or does again.
  virtual void SetDiskFull(bool full) = 0;
  /// How many files the log has: one for each start of the logger.
  virtual std::int64_t log_files() const = 0;
  /// The next event that is on the disk, and of which file; none now.
  virtual std::optional<std::pair<Packet, std::int64_t>> NextLogged() = 0;
  /// After the last event: what in that file belongs to no event; "": nothing.
  virtual std::string TornTail(std::int64_t file) const = 0;

  /// For the display.
  virtual void Say(const std::string& line) = 0;
  /// `lag_ticks`: ticks heard and not in the log yet. `at_end`: this is the last call.
  virtual void Show(const MissionView& logged, std::int64_t lag_ticks, bool at_end) = 0;
};

}  // namespace muster::tools
