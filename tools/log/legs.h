#pragma once

#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "model/agent.h"
#include "model/scenario.h"
#include "muster/agent_states_t.hpp"

namespace muster::tools {

/// A way that an agent has gone, or begun to go.
struct Leg {
  AgentState agent;     ///< as it was first reported on the leg: from, to, times, action
  TimeUs until_us = 0;  ///< it arrived, or set out elsewhere, or failed

  /// From end to end.
  std::vector<Point> Line() const;
};

/// Finds the legs of all agents in what they report. Memory grows with the agents, not with time.
class LegReader {
 public:
  using Visit = std::function<void(const Leg&)>;

  /// `scenario`: with the orders so far. Visits the legs that have ended.
  void Add(const agent_states_t& states, const Scenario& scenario, const Visit& visit);
  /// Nothing more comes; those that are under way have come to `now_us`.
  void Finish(TimeUs now_us, const Visit& visit);

 private:
  std::map<std::pair<AgentKind, std::int32_t>, AgentState> under_way_;
};

}  // namespace muster::tools
