#pragma once

#include <map>
#include <muster/event_t.hpp>
#include <string>
#include <utility>

#include "model/agent.h"

namespace muster::world {

/// Why driven agents cannot go on, as their processes say it beside the reports.
class DriverFailures {
 public:
  explicit DriverFailures(const Scenario& scenario) : scenario_(scenario) {}

  void Hear(const event_t& event);
  /// Whether a report that tells of that agent's failure is to be said again, since the reason was
  /// not heard: a few times.
  bool Awaits(const AgentState& agent);
  std::string Why(const AgentState& agent) const;

 private:
  using Key = std::pair<AgentKind, std::int32_t>;

  const Scenario& scenario_;
  std::map<Key, std::string> said_;
  std::map<Key, int> awaited_;
};

}  // namespace muster::world
