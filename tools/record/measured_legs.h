#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "model/scenario.h"
#include "muster/agent_t.hpp"
#include "muster/schedule_t.hpp"

namespace muster::tools {

/// A way that a decision sent a measured agent (model/measured.h).
struct MeasuredLeg {
  AgentKind kind = AgentKind::kUav;
  std::int32_t agent = -1;
  std::int32_t decision = -1;
  std::int32_t task = -1;    ///< -1: none
  std::int32_t charge = -1;  ///< charging point; -1: none
  double way_m = 0;          ///< straight, from where it was at the decision
  TimeUs sent_us = 0;        ///< time of the decision
  TimeUs planned_us = 0;     ///< arrival at full speed on that way
  /// Arrival as it was told. None: it has not arrived, or was sent elsewhere before.
  std::optional<TimeUs> arrived_us = {};
};

/// Compares planned with measured arrivals: gathers what measured agents have reported, in any
/// order of the messages.
class MeasuredLegs {
 public:
  /// Takes an agent's report for a tick.
  void Take(const Scenario& scenario, AgentKind kind, std::int64_t tick, const agent_t& agent);
  /// By class, agent and decision. Ways that take less than what arrivals are known to
  /// (kMeasuredSlackUs) are left out: it was there.
  std::vector<MeasuredLeg> List(const Scenario& scenario,
                                const std::map<std::int32_t, schedule_t>& schedules) const;

 private:
  struct Told {
    std::optional<Point> from = {};  ///< where it was at the decision
    double speed_m_s = 0;
    std::int64_t arrived_tick = kNever;  ///< the first at which it had arrived
    TimeUs arrived_us = 0;
  };
  struct Key {
    AgentKind kind;
    std::int32_t agent, decision;
    auto operator<=>(const Key&) const = default;
  };
  std::map<Key, Told> told_;
};

/// As report.json has it (docs/reference/report-format.md): one row per agent that was sent
/// somewhere.
nlohmann::ordered_json ToJson(const std::vector<MeasuredLeg>& legs);

}  // namespace muster::tools
