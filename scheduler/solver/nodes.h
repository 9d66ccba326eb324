#pragma once

#include <vector>

#include "scheduler/candidates.h"
#include "scheduler/solver/build.h"
#include "scheduler/weights.h"

namespace muster::scheduler {

/// The nodes that a BuiltInstance's arcs stand for, for algorithms that walk from node to node: the
/// paper's. In the order in which Algorithm 1 makes them, as EnumerateCandidates gives them, whose
/// weights they have up to rounding; charging points are numbered by those with a free place.
struct ArcNodes {
  BuiltInstance built;
  Elements elements;
  std::vector<Node> nodes;

  Action ToAction(const Situation& situation, const Node& node) const;
};

/// 24 bytes and O(1) a node.
ArcNodes ListNodes(const Situation& situation, Foundation foundation = Foundation::kHierarchical);

}  // namespace muster::scheduler
