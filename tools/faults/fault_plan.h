#pragma once

#include <muster/fault_t.hpp>
#include <optional>
#include <string>
#include <vector>

#include "model/scenario.h"
#include "protocol/fault_switch.h"

namespace muster::tools {

/// What a fault must lead to; scored after the mission (docs/guide/faults.md).
struct Expectations {
  std::optional<int> detected_within_ticks;
  std::optional<int> partner_released_within_decisions;
  std::optional<TimeUs> tasks_finished_by_us;  ///< those that it interrupted
  std::optional<double> completion_rate;       ///< at least
  bool same_decisions = false;                 ///< and outcomes, as without any fault
};

/// One fault to inject (docs/guide/faults.md).
struct PlannedFault {
  std::string id;
  FaultKind kind = FaultKind::kLoss;
  std::string target;
  TimeUs at_us = 0;   ///< mission time
  TimeUs for_us = 0;  ///< mission time; 0: see for_real_us
  TimeUs for_real_us =
      0;  ///< real time, for what holds the mission's clock; 0 with for_us 0: for good
  double probability = 0;  ///< a share of packets; for a delay its seconds
  Expectations expect = {};
  std::string where;  ///< "plan.json: faults[2]", for messages
};

/// In order of time, then as written.
using FaultPlan = std::vector<PlannedFault>;

/// Throws InputError naming file, key and what is expected.
FaultKind KindByName(const std::string& name, const std::string& file, std::string_view key);

/// Parses a plan file's text. Throws InputError naming file, key, value and what is expected.
FaultPlan ParseFaultPlan(const std::string& json, const std::string& file);
/// Reads a plan file. Throws InputError, also when it cannot be read.
FaultPlan LoadFaultPlan(const std::string& file);
/// "KIND:TARGET@MIN[+DURATION][=VALUE]": DURATION in mission minutes, or with an s behind it in
/// real seconds; VALUE is the share of packets, or the delay in ms. `number` makes the id.
PlannedFault ParseFaultFlag(const std::string& text, std::size_t number);

/// Throws InputError where a target is not among the processes `names` (the logger is lcm-logger)
/// or the scenario's agents, a fault comes after the limit, lasts in mission time though it holds
/// the clock, or an id comes twice. `goes_on`: the mission goes on without agent processes and
/// scheduler. `recorder_writes`: the recorder is no part of the launcher but a process that writes
/// the log; what names lcm-logger means it. Sorts by time.
void CheckFaultPlan(FaultPlan* plan, const std::vector<std::string>& names,
                    const Scenario& scenario, bool goes_on, bool recorder_writes = false);

/// As published when it begins; `header` is left for the sender. for_us is kNever when it is for
/// good, and never 0: that ends a fault.
fault_t ToWire(const PlannedFault& fault);

/// The plan as a plan file; expectations are left out.
std::string ToJson(const FaultPlan& plan);

/// The options by which muster-world is told of the plan's failing agents, closed roads and zones.
std::vector<std::string> WorldOptionsOf(const FaultPlan& plan);

}  // namespace muster::tools
