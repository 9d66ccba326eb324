#pragma once

#include <optional>
#include <span>
#include <string>

#include "model/agent.h"
#include "model/scenario.h"

namespace muster {

/// What a measured agent says of itself (docs/guide/drivers.md). The process that holds the agent
/// applies it before it reports the agent's state for a tick: all others take that state as it is
/// told.
struct MeasuredReport {
  enum class Kind : std::int8_t {
    kPlace,     ///< where it is, and perhaps when it expects to arrive
    kArrived,   ///< it is where it was sent
    kDone,      ///< its part of the sensing or charging is done
    kFailed,    ///< it cannot go on
    kNotReady,  ///< it has nothing to do, and cannot set out yet
    kReady,     ///< it can
  };
  AgentKind agent_kind = AgentKind::kUav;
  std::int32_t agent = -1;
  Kind kind = Kind::kPlace;
  std::int32_t decision = -1;              ///< kArrived, kDone: whose command it is about
  TimeUs at_us = 0;                        ///< when it was there, or said so
  Point at = {};                           ///< kPlace
  std::optional<double> range_m = {};      ///< kPlace, kDone of a UAV; none: as computed
  std::optional<TimeUs> expected_us = {};  ///< kPlace: arrival; none: at full speed from there
  std::string reason = {};                 ///< kFailed, kNotReady
};

/// What is told, and what was expected, differ by less than so long a time, or the way of so long a
/// time: nothing has changed. Clocks and places are no better known than that.
inline constexpr TimeUs kMeasuredSlackUs = kSecondUs;

/// Applies a report that is taken at tick time t. Returns why it is impossible ("": it is not); an
/// impossible one changes nothing. What agrees with the state to kMeasuredSlackUs changes nothing
/// either, so an agent that does as computed has the computed agent's outcomes, bit for bit.
/// kFailed changes no state: its failure is the world's to judge.
[[nodiscard]] std::string ApplyReport(AgentState* agent, const MeasuredReport& report, TimeUs t,
                                      std::span<const Task> tasks);

/// It is where it was sent, since then at the latest.
void HasArrived(AgentState* agent, TimeUs at_us);

/// Forgets that it said to be done with sensing or charging: that has not begun after all.
void HasNotBegun(AgentState* agent);

/// After the reports of tick time t: what was expected of a measured agent by then, arrival or the
/// end of its sensing or charging, and was not said, is expected at the next tick; what is done is
/// over by t. The rest of a leg that is not as planned begins where the agent is then.
void ExpectOnward(AgentState* agent, TimeUs t, TimeUs next_tick_us);

/// Gives a measured agent without a driver the state that is computed for time t.
void SayAsComputed(AgentState* agent, TimeUs t);

/// Whether a report tells the leg of a measured agent as it began, so that its arrival as planned
/// can be read from it, and the place and arrival as they are now: on its way to a partner.
bool TellsWholeLeg(const AgentState& agent, TimeUs t);

/// Completes a measured agent that was read from a message of time t, with its place and range at
/// that time. Whether it has arrived or is done follows from the times in the message.
void ReadMeasured(Point here, double range_left_m, TimeUs t, const Rules& rules,
                  AgentState* reported);

/// Whether a place is older than what the agent has said since, or than its leg.
bool IsOld(const AgentState& agent, const MeasuredReport& report);

/// A measured agent has set out on its present leg, or has come to stand still.
void NoteLeg(AgentState* agent);

/// Whether nothing is left to be reported about the agent's part in its sensing or charging. A
/// computed agent reports nothing, and need not.
inline bool SaysDone(const AgentState& agent) { return !agent.measured || agent.measured->done; }
inline bool SaysArrived(const AgentState& agent) {
  return !agent.measured || agent.measured->arrived;
}

}  // namespace muster
