#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "model/agent.h"
#include "model/clearance.h"
#include "model/scenario.h"
#include "model/separation.h"
#include "muster/agent_states_t.hpp"
#include "muster/clearances_t.hpp"

namespace muster::tools {

/// What the decisions of a mission that keeps UAVs apart have planned in the air. Memory grows with
/// UAVs times decisions; of missions with more than kMostUavs nothing is kept but the altitudes.
class AirRecord {
 public:
  static constexpr std::size_t kMostUavs = 2000;

  /// `scenario`: with the orders so far; it must outlive this object.
  void Take(const clearances_t& clearances, const Scenario& scenario);
  /// Of the UAVs: counts where it is of the tick after a decision.
  void Take(const agent_states_t& states, const Scenario& scenario);

  struct Decision {
    std::vector<Clearance> clearances;        ///< by UAV
    std::map<std::int32_t, AgentState> uavs;  ///< by id, on the leg that the decision sent them on
  };
  const std::map<std::int32_t, Decision>& decisions() const { return decisions_; }

 private:
  std::map<std::int32_t, Decision> decisions_;
};

/// A UAV's flight from one decision about it to the next, or to the end of the mission.
struct Flight {
  AgentState uav;
  Clearance clearance;
  TimeUs from_us = 0, until_us = 0;
};
/// By UAV and time, without decisions that were not in force.
std::vector<Flight> FlightsOf(const AirRecord& air, const Scenario& scenario,
                              const std::set<std::int32_t>& skipped);

/// A mission's air in figures.
struct AirSummary {
  std::set<double> altitudes_m;  ///< that were given
  std::int64_t held = 0;         ///< UAVs that waited for their altitude
  TimeUs held_us = 0;            ///< in sum
  struct Closest {
    Approach approach;
    std::int32_t decision = -1;
    std::pair<std::int32_t, std::int32_t> uavs;
    TimeUs at_us = 0;
  };
  /// Of all pairs whose ways come near each other; none: there is none, or more UAVs than are
  /// looked at.
  std::optional<Closest> closest;
  std::int64_t conflicts = 0;  ///< pairs, by decision, that come closer than both minima
};
AirSummary SummaryOf(const AirRecord& air, const Scenario& scenario,
                     const std::set<std::int32_t>& skipped);

}  // namespace muster::tools
