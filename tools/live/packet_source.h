#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/units.h"
#include "lcmtypes/bus/bus.h"
#include "lcmtypes/bus/event_log.h"
#include "tools/report/mission_feed.h"

namespace muster::tools {

/// A mission to look on at: a run that is being written (or has been), or the bus.
class PacketSource {
 public:
  virtual ~PacketSource() = default;
  /// What is new; waits at most that long for it. Returns early when a signal arrives.
  virtual std::vector<Packet> Read(TimeUs wait_us) = 0;
  /// All that there is now has been read when Read gives nothing.
  virtual bool is_log() const = 0;
  /// For people.
  virtual std::string name() const = 0;
};

/// Run directory or log file when it is no LCM URL ("udpm://..."). Throws InputError, SystemError.
std::unique_ptr<PacketSource> OpenPacketSource(const std::string& run_or_url);

/// The run or URL to look at where nobody names one: the newest run of the folder runs, if it goes
/// on; else the bus. Says on stderr which.
std::string MissionHere();

/// Asks for the scenario on the bus if the mission began before this process listened. The question
/// is one message with one seq, repeated until it is answered, so the mission's log stays without
/// gaps. The world answers by its scenario and clock.
class ScenarioRequest {
 public:
  /// The packet to publish now, if any. `heard`: the run that is heard; `known`: its scenario is.
  std::optional<Packet> Due(std::optional<std::int64_t> heard, bool known, TimeUs now_us);

 private:
  std::optional<std::int64_t> run_id_;
  std::optional<Packet> packet_;
  TimeUs due_us_ = 0;
};

}  // namespace muster::tools
