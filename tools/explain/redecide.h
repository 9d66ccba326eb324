#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/explain/decision_log.h"

namespace muster::tools {

/// One decision made again from what the log holds of it.
struct Redecided {
  std::int32_t decision = -1;
  TimeUs at_us = 0;
  /// Why it could not be made again; else empty.
  std::string missing;
  std::vector<schedule_t> logged;  ///< as LoggedDecision::schedules
  schedule_t again = {};           ///< when nothing is missing
  /// The first altitude that differs, or a list that one of both lacks; empty: none.
  std::string altitudes = {};
};

/// Gives the log's messages to the scheduler's process once more, decision by decision: the same
/// core that runs in a mission, packets in, schedule_t out. `policy` is how it decides; empty: as
/// the logged schedules say. Decisions of which the log holds neither a schedule nor all messages
/// are left out: the mission ended there. Throws InputError for an unknown policy, and
/// where an outside program decided and `policy` is empty: a log runs nothing.
std::vector<Redecided> Redecide(const DecisionLog& log, const std::string& policy,
                                const DecisionProgress& progress = {});

/// The first field in which two schedules differ, header and solve_us aside, with both values:
/// "actions[3].weight is 2.5, the log says 2.25". Numbers are compared bit for bit. Empty: none.
std::string FirstDifference(const schedule_t& again, const schedule_t& logged);

/// How many actions the two decisions do not share, not counting stays.
struct ActionDifference {
  int only_logged = 0, only_again = 0;
};
ActionDifference DifferenceOf(const schedule_t& again, const schedule_t& logged);

/// The outcome of a comparison with the same policy.
struct Divergence {
  std::int32_t decision = -1;
  TimeUs at_us = 0;
  std::string what;
};
/// In the order of decisions: differing schedules, schedules that could not be made again.
std::vector<Divergence> DivergencesOf(const std::vector<Redecided>& decisions);

}  // namespace muster::tools
