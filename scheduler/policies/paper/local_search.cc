#include "scheduler/policies/paper/local_search.h"

#include <algorithm>

namespace muster::scheduler::paper {

WorkingGraph::WorkingGraph(const Elements& elements, const std::vector<Node>& nodes)
    : elements_(&elements),
      all_nodes_(&nodes),
      holding_(elements.capacity.size()),
      solo_(static_cast<std::size_t>(elements.n_agents())) {}

void WorkingGraph::Add(NodeId id) {
  members_.push_back(id);
  const NodeElements own = ElementsOf(node(id), *elements_);
  for (const int element : own) holding_[static_cast<std::size_t>(element)].push_back(id);
  if (own.element[0] >= elements_->n_uavs) {
    solo_[static_cast<std::size_t>(own.element[0])].push_back(id);
  }
}

void WorkingGraph::AddAll() {
  std::vector<std::size_t> count(holding_.size());
  for (const Node& each : *all_nodes_) {
    for (const int element : ElementsOf(each, *elements_)) {
      ++count[static_cast<std::size_t>(element)];
    }
  }
  for (std::size_t element = 0; element < count.size(); ++element) {
    holding_[element].reserve(count[element]);
  }
  members_.reserve(all_nodes_->size());
  for (std::size_t id = 0; id < all_nodes_->size(); ++id) Add(static_cast<NodeId>(id));
}

SigmaQueue::SigmaQueue(const WorkingGraph& graph)
    : graph_(&graph),
      best_(static_cast<std::size_t>(graph.elements().n_agents())),
      stale_(best_.size(), 0) {}

void SigmaQueue::Search(const Solution& solution, int agent) {
  Entry best;
  for (const NodeId node : graph_->of_agent(agent)) {
    const double sigma = solution.Sigma(node);
    if (Better(sigma, node, best)) best = {sigma, node};
  }
  best_[static_cast<std::size_t>(agent)] = best;
}

void SigmaQueue::Rebuild(const Solution& solution) {
  for (int agent = 0; agent < graph_->elements().n_agents(); ++agent) Search(solution, agent);
}

void SigmaQueue::Update(const Solution& solution, std::vector<int> elements) {
  std::sort(elements.begin(), elements.end());
  elements.erase(std::unique(elements.begin(), elements.end()), elements.end());
  const Elements& all = graph_->elements();
  std::vector<int> again;
  const auto mark = [&](int agent) {
    if (stale_[static_cast<std::size_t>(agent)]) return;
    stale_[static_cast<std::size_t>(agent)] = 1;
    again.push_back(agent);
  };
  for (const int element : elements) {
    if (element < all.n_uavs) mark(element);  // all of its nodes hold it
  }
  for (const int element : elements) {
    if (element < all.n_uavs) continue;
    for (const NodeId node : graph_->holding(element)) {
      const Node& each = graph_->node(node);
      const int agent = ElementsOf(each, all).element[0];
      if (stale_[static_cast<std::size_t>(agent)]) continue;
      Entry& best = best_[static_cast<std::size_t>(agent)];
      // The sigma of a node is at most its weight.
      if (node != best.node && each.weight < best.sigma) continue;
      const double sigma = solution.Sigma(node);
      if (node == best.node) {
        if (sigma < best.sigma) {
          mark(agent);
        } else {
          best.sigma = sigma;
        }
      } else if (Better(sigma, node, best)) {
        best = {sigma, node};
      }
    }
  }
  for (const int agent : again) {
    Search(solution, agent);
    stale_[static_cast<std::size_t>(agent)] = 0;
  }
}

SigmaQueue::Entry SigmaQueue::top() const {
  Entry top;
  for (const Entry& entry : best_) {
    if (entry.node != kNoNode && Better(entry.sigma, entry.node, top)) top = entry;
  }
  return top.node != kNoNode && top.sigma > kLeastGain ? top : Entry{};
}

void LocalSearch(const WorkingGraph& graph, Solution* solution, SigmaQueue* queue) {
  std::vector<int> changed;
  for (SigmaQueue::Entry top = queue->top(); top.node != kNoNode; top = queue->top()) {
    changed.clear();
    const auto touch = [&](NodeId node) {
      const NodeElements own = ElementsOf(graph.node(node), graph.elements());
      changed.insert(changed.end(), own.begin(), own.end());
    };
    for (const NodeId other : solution->Conflicts(top.node)) {
      touch(other);
      solution->Remove(other);
    }
    touch(top.node);
    solution->Add(top.node);
    queue->Update(*solution, changed);
  }
}

}  // namespace muster::scheduler::paper
