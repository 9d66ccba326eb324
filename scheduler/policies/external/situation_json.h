#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "scheduler/situation.h"
#include "scheduler/solver/candidates.h"

namespace muster::scheduler {

/// What a program has asked to be told besides the situation.
struct GraphWishes {
  bool nodes = false;  ///< the candidate actions with their weights and elements
  bool edges = false;  ///< and the pairs of nodes that conflict
};

/// A situation as the lines of docs/guide/external-schedulers.md have it: seconds, metres, ids of
/// the scenario. `candidates`: of that situation, when nodes or edges are wished for.
nlohmann::ordered_json ToJson(const Situation& situation);
void AddGraph(const Situation& situation, const Candidates& candidates, const GraphWishes& wishes,
              nlohmann::ordered_json* json);

/// Larger graphs are not written out: `nodes` (`edges`) is null then.
inline constexpr std::size_t kMostNodes = 200'000;
inline constexpr std::size_t kMostEdges = 1'000'000;

}  // namespace muster::scheduler
