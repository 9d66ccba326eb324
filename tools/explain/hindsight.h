#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/explain/decision_log.h"

namespace muster::tools {

/// What a mission came to, or could have come to.
struct Outcome {
  std::size_t done = 0;  ///< tasks
  double worth = 0;      ///< of them, by priority and due time, in tasks of normal priority
};

/// One decision in hindsight.
struct HindsightDecision {
  std::int32_t decision = -1;
  TimeUs at_us = 0;
  std::string missing;            ///< why nothing can be told; else empty
  Outcome best;                   ///< the best that was found to follow, with what was done before
  Outcome lost;                   ///< how much less was found to be possible at the next decision
  std::size_t failed = 0;         ///< agents that failed until the next decision
  std::vector<Action> better;     ///< of the best plan; not commanded
  std::vector<Action> commanded;  ///< instead of them
};

/// A finished mission beside the best plans that a search finds when all is known that was still to
/// come.
struct Hindsight {
  std::string policy;  ///< of the log's first schedule; "": it has none
  std::size_t tasks = 0;
  Outcome was;
  Outcome best;  ///< at mission start; was, where nothing better is found
  std::vector<HindsightDecision> decisions;
  std::vector<std::int32_t> missed;  ///< tasks that the best plan does and the mission did not
};

/// Searches at each logged decision (scheduler::RolloutPolicy with that effort) for the best plan
/// from there on. The search knows all agents that came or left, when each failed, and all tasks
/// that were reported. It does not know what goes wrong by chance: wind, loss of range, failed
/// matches. Roads and zones are those of the decision. What follows a decision also could have
/// followed the one before, so what is possible never grows from one decision to the next, and the
/// sum of what was lost is what lies between the best plan and the mission. Throws InputError
/// naming `run` when the log does not go to the mission's end. Source: ours.
Hindsight LookBack(const DecisionLog& log, const std::string& run, std::int64_t effort,
                   const DecisionProgress& progress = {});

/// For people.
std::string ToText(const Hindsight& hindsight);
/// The same facts for tools (docs/guide/explain.md).
nlohmann::ordered_json ToJson(const Hindsight& hindsight);

}  // namespace muster::tools
