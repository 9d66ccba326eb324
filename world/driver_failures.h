#pragma once

#include <map>
#include <muster/event_t.hpp>
#include <string>
#include <utility>

#include "model/agent.h"

namespace muster::world {

/// Why agents with drivers cannot go on: their processes send the reason beside the reports.
class DriverFailures {
 public:
  explicit DriverFailures(const Scenario& scenario) : scenario_(scenario) {}

  void Hear(const event_t& event);
  /// Whether to ask for a report again that says that the agent has failed, because the reason was
  /// not heard. True a few times at most.
  bool Awaits(const AgentState& agent);
  std::string Why(const AgentState& agent) const;

 private:
  using Key = std::pair<AgentKind, std::int32_t>;

  const Scenario& scenario_;
  std::map<Key, std::string> said_;
  std::map<Key, int> awaited_;
};

}  // namespace muster::world
