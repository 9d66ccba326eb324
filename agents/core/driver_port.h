#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "model/clearance.h"
#include "model/measured.h"

namespace muster::agents {

/// What a driver has to say to people.
struct DriverMessage {
  std::int32_t agent = -1;
  std::string text;
  bool calls_help = false;
};

/// Speaks for the measured agents of a process: driver programs, or a stand-in of a test.
class DriverPort {
 public:
  virtual ~DriverPort() = default;

  /// The driver of that agent begins, with the agent as it is at `at`. The scenario must outlive
  /// this object.
  virtual void Begin(const Scenario& scenario, const AgentState& agent, TimeUs at) = 0;
  virtual bool drives(std::int32_t id) const = 0;
  /// The altitude that a decision gives a UAV; what it is sent to do is told after it.
  virtual void GiveAltitude(const Clearance& /*clearance*/) {}
  /// Tells the driver what the agent's state was at `before`, the last tick, and that it is now
  /// `at`.
  virtual void Tell(const AgentState& agent, TimeUs before, TimeUs at) = 0;
  /// Reads what the drivers have said since. Returns true when no driver has to be waited for. May
  /// wait a few milliseconds itself.
  virtual bool Listen() = 0;
  /// What was reported for a tick at `at`, in order. A failure is an agent's last report.
  virtual std::vector<MeasuredReport> TakeReports(TimeUs at) = 0;
  /// What the drivers have said to people since the last call.
  virtual std::vector<DriverMessage> TakeMessages() { return {}; }
  /// The longest time between two calls of Listen() while no driver has to be waited for.
  virtual TimeUs patience_us() const = 0;
  /// The mission is over.
  virtual void Bye(std::string_view reason) = 0;
};

}  // namespace muster::agents
