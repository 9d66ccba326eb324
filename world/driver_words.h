#pragma once

#include <map>
#include <muster/event_t.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "model/agent.h"

namespace muster::world {

/// What the drivers of measured agents say in words: why one cannot go on, what it waits for, or a
/// message to people. Their processes send it beside the reports.
class DriverWords {
 public:
  explicit DriverWords(const Scenario& scenario) : scenario_(scenario) {}

  /// Returns whether the mission is to hear of it: what a driver waits for, or a message, as it is
  /// heard first.
  bool Hear(const event_t& event);
  /// Whether to ask for a report again that says that the agent has failed, because the reason was
  /// not heard. True a few times at most.
  bool Awaits(const AgentState& agent);
  std::string WhyFailed(const AgentState& agent) const;

 private:
  using Key = std::pair<AgentKind, std::int32_t>;

  /// The measured agent that the event names; none: it names none.
  std::optional<Key> AgentOf(const event_t& event) const;

  const Scenario& scenario_;
  std::map<Key, std::string> failures_;
  std::map<Key, TimeUs> waits_said_us_;  ///< of the newest word
  std::map<std::pair<Key, std::int8_t>, std::set<std::pair<TimeUs, std::string>>> messages_;
  std::map<Key, int> awaited_;
};

}  // namespace muster::world
