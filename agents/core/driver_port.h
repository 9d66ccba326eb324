#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "model/measured.h"

namespace muster::agents {

/// Who speaks for measured agents of a process: programs, or what a test has in their place.
class DriverPort {
 public:
  virtual ~DriverPort() = default;

  /// Who drives that agent is to begin, with the agent as it is at `at`. The scenario must outlive
  /// this object.
  virtual void Begin(const Scenario& scenario, const AgentState& agent, TimeUs at) = 0;
  virtual bool drives(std::int32_t id) const = 0;
  /// Tells what has become of the agent at `before`, the last tick, and that it is `at`.
  virtual void Tell(const AgentState& agent, TimeUs before, TimeUs at) = 0;
  /// Hears what has been said since. Whether there is nobody to be waited for; it may wait a few
  /// milliseconds itself.
  virtual bool Listen() = 0;
  /// What was said for a tick at `at`, in order. A failure is an agent's last word.
  virtual std::vector<MeasuredReport> TakeReports(TimeUs at) = 0;
  /// How long it may not be listened to, while nobody is waited for.
  virtual TimeUs patience_us() const = 0;
  /// The mission is over.
  virtual void Bye(std::string_view reason) = 0;
};

}  // namespace muster::agents
