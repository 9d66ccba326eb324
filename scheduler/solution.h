#pragma once

#include <vector>

#include "scheduler/nodes.h"

namespace muster::scheduler {

/// An independent set of nodes, kept as the occupancy of the elements: the node that holds each
/// UAV, worker, vehicle, task and charging point. That is the whole conflict graph: a node
/// conflicts with those that hold its elements, so adding, removing and asking cost O(3), and no
/// edge exists.
///
/// A charging point with c > 1 free places admits c nodes. When it is full, a newcomer conflicts
/// with the one that would have to leave: the lightest, among equals the one with the largest id.
class Solution {
 public:
  /// Empty. Both must outlive this and stay in place; nodes may be appended.
  Solution(const Elements& elements, const std::vector<Node>& nodes);

  /// Nodes of the solution that would have to leave for `node` to join; at most 3.
  struct Conflict {
    NodeId node[3] = {kNoNode, kNoNode, kNoNode};
    int n = 0;
    const NodeId* begin() const { return node; }
    const NodeId* end() const { return node + n; }
  };
  Conflict Conflicts(NodeId node) const;

  bool contains(NodeId node) const {
    const NodeElements own = ElementsOf(Get(node), *elements_);
    return owner_[At(own.element[0])] == node;
  }
  bool Fits(NodeId node) const { return !contains(node) && Conflicts(node).n == 0; }

  /// sigma: what the solution gains when the node joins and its conflicts leave; for a node of the
  /// solution minus infinity. Source: section 4.2.1, before Alg. 3.
  double Sigma(NodeId node) const;

  /// The node must fit.
  void Add(NodeId node);
  /// The node must be in the solution.
  void Remove(NodeId node);

  /// Whether the element (see Elements) takes no further node.
  bool full(int element) const;
  /// The node that occupies an agent or a task; kNoNode when it is free.
  NodeId owner(int element) const { return owner_[At(element)]; }

  double weight() const;              ///< summed in the order of the ids
  std::vector<NodeId> nodes() const;  ///< ascending
  std::size_t size() const { return size_; }

 private:
  static std::size_t At(int i) { return static_cast<std::size_t>(i); }
  const Node& Get(NodeId node) const { return (*nodes_)[At(node)]; }

  const Elements* elements_;
  const std::vector<Node>* nodes_;
  /// [n_elements]; unused where more than one node is admitted.
  std::vector<NodeId> owner_;
  /// [n_elements]; used where more than one, but not any number, is admitted.
  std::vector<std::vector<NodeId>> occupants_;
  std::size_t size_ = 0;
};

}  // namespace muster::scheduler
