#include "scheduler/policies/paper/perturbation.h"

#include <algorithm>
#include <utility>

namespace muster::scheduler::paper {
namespace {

/// `count` random items of `items`, drawn without replacement.
std::vector<NodeId> Choose(std::vector<NodeId> items, std::size_t count, Random* random) {
  for (std::size_t i = 0; i < count; ++i) {
    const auto left = static_cast<std::uint32_t>(items.size() - i);
    std::swap(items[i], items[i + random->Below(left)]);
  }
  items.resize(count);
  return items;
}

}  // namespace

std::vector<int> Perturb(const WorkingGraph& graph, int iteration, int strength, Random* random,
                         Solution* solution) {
  const int label = iteration % 3;
  std::vector<NodeId> stratum;
  for (const NodeId node : solution->nodes()) {
    if (Level(graph.node(node).kind) == label) stratum.push_back(node);
  }
  const int wanted = label == 2 ? std::max(1, strength / 2) : strength;
  const std::size_t count = std::min(stratum.size(), static_cast<std::size_t>(wanted));
  const std::vector<NodeId> removed = Choose(std::move(stratum), count, random);

  std::vector<int> changed;
  for (const NodeId node : removed) {
    solution->Remove(node);
    const NodeElements own = ElementsOf(graph.node(node), graph.elements());
    changed.insert(changed.end(), own.begin(), own.end());
  }
  // C. Its members must fit what is left, so those that do not are skipped before the shuffle: in a
  // random order of all they would be passed over anyway. What shares an element with a removed
  // node and fits now did not fit before, but for charging points that were not full.
  std::vector<NodeId> barriers;
  for (const int element : changed) {
    for (const NodeId node : graph.holding(element)) {
      if (Level(graph.node(node).kind) != label && solution->Fits(node)) barriers.push_back(node);
    }
  }
  std::sort(barriers.begin(), barriers.end());
  barriers.erase(std::unique(barriers.begin(), barriers.end()), barriers.end());
  random->Shuffle(barriers);
  for (const NodeId node : barriers) {
    if (!solution->Fits(node)) continue;
    solution->Add(node);
    const NodeElements own = ElementsOf(graph.node(node), graph.elements());
    changed.insert(changed.end(), own.begin(), own.end());
  }
  return changed;
}

}  // namespace muster::scheduler::paper
