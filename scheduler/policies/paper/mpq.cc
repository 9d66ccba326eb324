#include "scheduler/policies/paper/mpq.h"

#include <algorithm>
#include <vector>

#include "scheduler/policies/paper/local_search.h"

namespace muster::scheduler::paper {
namespace {

/// The queues Q_k, one per idle agent: its nodes, the heaviest first, then the smallest id. A node
/// with a UAV is only in the UAV's.
class AgentQueues {
 public:
  AgentQueues(const Elements& elements, const std::vector<Node>& nodes)
      : nodes_(&nodes), heaps_(static_cast<std::size_t>(elements.n_agents())) {
    for (std::size_t id = 0; id < nodes_->size(); ++id) {
      const int agent = ElementsOf((*nodes_)[id], elements).element[0];
      heaps_[static_cast<std::size_t>(agent)].push_back(static_cast<NodeId>(id));
    }
    for (auto& heap : heaps_) std::make_heap(heap.begin(), heap.end(), Later{nodes_});
  }

  bool empty() const {
    return std::all_of(heaps_.begin(), heaps_.end(), [](const auto& heap) { return heap.empty(); });
  }

  /// Moves up to k nodes of every queue into the graph.
  void Extract(std::int64_t k, WorkingGraph* graph) {
    for (auto& heap : heaps_) {
      for (std::int64_t i = 0; i < k && !heap.empty(); ++i) {
        std::pop_heap(heap.begin(), heap.end(), Later{nodes_});
        graph->Add(heap.back());
        heap.pop_back();
      }
    }
  }

 private:
  struct Later {
    const std::vector<Node>* nodes;
    bool operator()(NodeId a, NodeId b) const {
      const double x = (*nodes)[static_cast<std::size_t>(a)].weight;
      const double y = (*nodes)[static_cast<std::size_t>(b)].weight;
      return x < y || (x == y && a > b);
    }
  };

  const std::vector<Node>* nodes_;
  std::vector<std::vector<NodeId>> heaps_;
};

bool AllRepresented(const Solution& solution, const Elements& elements) {
  for (int agent = 0; agent < elements.n_agents(); ++agent) {
    if (solution.owner(agent) == kNoNode) return false;
  }
  return true;
}

}  // namespace

Solution MultiPriorityQueues(const Elements& elements, const std::vector<Node>& nodes,
                             std::uint64_t seed, std::int32_t decision, int max_iterations) {
  AgentQueues queues(elements, nodes);
  WorkingGraph graph(elements, nodes);
  Solution current(elements, nodes);
  std::int64_t k = 1;
  for (std::uint64_t round = 0; !queues.empty() && !AllRepresented(current, elements); ++round) {
    queues.Extract(k, &graph);
    Solution candidate = IteratedLocalSearch(
        graph, current, Random(seed, Stream::kPolicy, round, static_cast<std::uint32_t>(decision)),
        max_iterations);
    // The search starts from `current`: what it returns is the best so far whenever it gains.
    if (candidate.weight() > current.weight() + kLeastGain) {
      current = std::move(candidate);
    } else {
      k *= 2;
    }
  }
  return current;
}

}  // namespace muster::scheduler::paper
