#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/per_kind.h"
#include "scheduler/nodes.h"
#include "scheduler/solver/build.h"
#include "scheduler/weights.h"

namespace muster::scheduler {

/// All feasible nodes of a situation, read from the arcs, in the order in which Algorithm 1 makes
/// them: per UAV its stay, its tasks (the move, then the pairs), its charging points (likewise);
/// per worker and per vehicle its stay and its moves. The edges are never stored: Solution finds
/// conflicts from the elements. Source: Alg. 1 (WUGCA) without the edges.
struct Candidates {
  BuiltInstance built;
  Elements elements;
  std::vector<Node> nodes;

  /// The UAV and the partner of a node that has one.
  const AgentState& UavOf(const Node& node) const;
  const AgentState& PartnerOf(const Node& node) const;
  Action ToAction(const Situation& situation, const Node& node) const;
  /// "uav:3", "task:17": the name of an element of the conflict graph.
  std::string NameOf(std::int32_t element) const;
};

/// 24 bytes and O(1) a node.
Candidates EnumerateCandidates(const Situation& situation,
                               Foundation foundation = Foundation::kHierarchical);

/// The paper's weights of single actions, for callers that ask about a few and need no list of all
/// pairs.
class ActionWeights {
 public:
  explicit ActionWeights(const Situation& situation);

  /// None for a free move and for what is no candidate. O(log n).
  std::optional<double> Of(const Action& action) const;

 private:
  BuiltInstance built_;
  ArcsByAgent of_uav_, of_partner_;
  PerKind<std::vector<std::int32_t>> agent_of_id_;  ///< by id; -1: not idle
  std::vector<std::int32_t> site_of_task_;          ///< by id; -1: not open
};

}  // namespace muster::scheduler
