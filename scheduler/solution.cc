#include "scheduler/solution.h"

#include <algorithm>
#include <limits>

#include "base/check.h"

namespace muster::scheduler {
namespace {

constexpr std::int32_t kUnlimited = std::numeric_limits<std::int32_t>::max();

}  // namespace

Solution::Solution(const Elements& elements, const std::vector<Node>& nodes)
    : elements_(&elements),
      nodes_(&nodes),
      owner_(elements.capacity.size(), kNoNode),
      occupants_(elements.capacity.size()) {}

Solution::Conflict Solution::Conflicts(NodeId node) const {
  Conflict conflict;
  const auto known = [&conflict](NodeId other) {
    return std::find(conflict.begin(), conflict.end(), other) != conflict.end();
  };
  for (const int element : ElementsOf(Get(node), *elements_)) {
    const std::int32_t capacity = elements_->capacity[At(element)];
    if (capacity == 1) {
      const NodeId owner = owner_[At(element)];
      if (owner != kNoNode && owner != node && !known(owner)) conflict.node[conflict.n++] = owner;
    } else if (capacity != kUnlimited) {
      // The site is the last element: the nodes that leave because of the agents are known by now.
      NodeId leaves = kNoNode;
      std::int32_t stay = 0;
      for (const NodeId other : occupants_[At(element)]) {
        if (other == node || known(other)) continue;
        ++stay;
        if (leaves == kNoNode || Get(other).weight < Get(leaves).weight ||
            (Get(other).weight == Get(leaves).weight && other > leaves)) {
          leaves = other;
        }
      }
      if (stay >= capacity && leaves != kNoNode) conflict.node[conflict.n++] = leaves;
    }
  }
  return conflict;
}

double Solution::Sigma(NodeId node) const {
  if (contains(node)) return -std::numeric_limits<double>::infinity();
  double sigma = Get(node).weight;
  for (const NodeId other : Conflicts(node)) sigma -= Get(other).weight;
  return sigma;
}

void Solution::Add(NodeId node) {
  MUSTER_CHECK(Fits(node), "node={}", node);
  for (const int element : ElementsOf(Get(node), *elements_)) {
    const std::int32_t capacity = elements_->capacity[At(element)];
    if (capacity == 1) {
      owner_[At(element)] = node;
    } else if (capacity != kUnlimited) {
      occupants_[At(element)].push_back(node);
    }
  }
  ++size_;
}

void Solution::Remove(NodeId node) {
  MUSTER_CHECK(contains(node), "node={}", node);
  for (const int element : ElementsOf(Get(node), *elements_)) {
    const std::int32_t capacity = elements_->capacity[At(element)];
    if (capacity == 1) {
      owner_[At(element)] = kNoNode;
    } else if (capacity != kUnlimited) {
      std::erase(occupants_[At(element)], node);
    }
  }
  --size_;
}

bool Solution::full(int element) const {
  const std::int32_t capacity = elements_->capacity[At(element)];
  if (capacity == 1) return owner_[At(element)] != kNoNode;
  return capacity != kUnlimited &&
         occupants_[At(element)].size() >= static_cast<std::size_t>(capacity);
}

double Solution::weight() const {
  double sum = 0;
  for (const NodeId node : nodes()) sum += Get(node).weight;
  return sum;
}

std::vector<NodeId> Solution::nodes() const {
  std::vector<NodeId> result;
  result.reserve(size_);
  for (int agent = 0; agent < elements_->n_agents(); ++agent) {
    const NodeId node = owner_[At(agent)];
    // A pair is counted at its UAV, its first element.
    if (node != kNoNode && ElementsOf(Get(node), *elements_).element[0] == agent) {
      result.push_back(node);
    }
  }
  std::sort(result.begin(), result.end());
  return result;
}

}  // namespace muster::scheduler
