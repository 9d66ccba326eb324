#pragma once

#include <vector>

#include "scheduler/nodes.h"
#include "scheduler/solution.h"

namespace muster::scheduler::paper {

/// A gain below this is rounding, not an improvement.
inline constexpr double kLeastGain = 1e-9;

/// The graph that is being solved, G or the growing G_sub: which nodes take part, listed by the
/// elements that they hold and by the agent that they belong to (a node with a UAV to the UAV).
class WorkingGraph {
 public:
  /// Without nodes. Both must outlive this.
  WorkingGraph(const Elements& elements, const std::vector<Node>& nodes);

  void Add(NodeId node);
  void AddAll();

  const Elements& elements() const { return *elements_; }
  const std::vector<Node>& all_nodes() const { return *all_nodes_; }
  const Node& node(NodeId id) const { return (*all_nodes_)[static_cast<std::size_t>(id)]; }
  /// Nodes of the graph, in the order in which they were added.
  const std::vector<NodeId>& members() const { return members_; }
  /// Nodes that hold an element.
  const std::vector<NodeId>& holding(int element) const {
    return holding_[static_cast<std::size_t>(element)];
  }
  /// Nodes that belong to an agent.
  const std::vector<NodeId>& of_agent(int agent) const {
    const auto i = static_cast<std::size_t>(agent);
    return agent < elements_->n_uavs ? holding_[i] : solo_[i];
  }

 private:
  const Elements* elements_;
  const std::vector<Node>* all_nodes_;
  std::vector<NodeId> members_;
  std::vector<std::vector<NodeId>> holding_;  // [n_elements]
  std::vector<std::vector<NodeId>> solo_;     // [n_agents], only workers and vehicles
};

/// The paper's queue Q: gives the node outside the solution with the largest sigma, among equals
/// the smallest id. Keeps the best node of each agent; a change of the solution touches only the
/// nodes that hold a changed element, and of the agents only those whose best fell are searched
/// anew.
class SigmaQueue {
 public:
  explicit SigmaQueue(const WorkingGraph& graph);

  /// O(nodes of the graph).
  void Rebuild(const Solution& solution);
  /// After the holders of `elements` (in any order, repeats allowed) changed.
  void Update(const Solution& solution, std::vector<int> elements);

  struct Entry {
    double sigma = 0;
    NodeId node = kNoNode;
  };
  /// kNoNode when no node has a sigma above kLeastGain.
  Entry top() const;

 private:
  void Search(const Solution& solution, int agent);
  static bool Better(double sigma, NodeId node, const Entry& than) {
    return than.node == kNoNode || sigma > than.sigma || (sigma == than.sigma && node < than.node);
  }

  const WorkingGraph* graph_;
  std::vector<Entry> best_;  // [n_agents]
  std::vector<char> stale_;  // [n_agents], all 0 between calls
};

/// LSOA: moves nodes with the largest sigma > kLeastGain in, and their conflicts out, until there
/// is none. `queue` must be up to date with the solution, and is so again afterwards.
/// Source: Alg. 3.
void LocalSearch(const WorkingGraph& graph, Solution* solution, SigmaQueue* queue);

}  // namespace muster::scheduler::paper
