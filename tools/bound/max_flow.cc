#include "tools/bound/max_flow.h"

#include <algorithm>
#include <limits>

#include "base/index.h"

namespace muster::tools {

void MaxFlow::Arc(std::int32_t from, std::int32_t to, std::int32_t capacity) {
  halves_.push_back({to, first_[At(from)], capacity});
  first_[At(from)] = static_cast<std::int32_t>(halves_.size()) - 1;
  halves_.push_back({from, first_[At(to)], 0});
  first_[At(to)] = static_cast<std::int32_t>(halves_.size()) - 1;
}

bool MaxFlow::Layer(std::int32_t source, std::int32_t sink) {
  layer_.assign(first_.size(), -1);
  layer_[At(source)] = 0;
  std::vector<std::int32_t> queue = {source};
  for (std::size_t i = 0; i < queue.size(); ++i) {
    for (std::int32_t h = first_[At(queue[i])]; h >= 0; h = halves_[At(h)].next) {
      const Half& half = halves_[At(h)];
      if (half.left == 0 || layer_[At(half.to)] >= 0) continue;
      layer_[At(half.to)] = layer_[At(queue[i])] + 1;
      queue.push_back(half.to);
    }
  }
  return layer_[At(sink)] >= 0;
}

std::int32_t MaxFlow::Push(std::int32_t node, std::int32_t sink, std::int32_t most) {
  if (node == sink) return most;
  std::int32_t pushed = 0;
  for (std::int32_t& h = current_[At(node)]; h >= 0; h = halves_[At(h)].next) {
    Half& half = halves_[At(h)];
    if (half.left == 0 || layer_[At(half.to)] != layer_[At(node)] + 1) continue;
    const std::int32_t part = Push(half.to, sink, std::min(most - pushed, half.left));
    half.left -= part;
    halves_[At(h ^ 1)].left += part;
    pushed += part;
    if (pushed == most) return pushed;
  }
  return pushed;
}

std::int64_t MaxFlow::Solve(std::int32_t source, std::int32_t sink) {
  std::int64_t flow = 0;
  while (Layer(source, sink)) {
    current_ = first_;
    flow += Push(source, sink, std::numeric_limits<std::int32_t>::max());
  }
  return flow;
}

}  // namespace muster::tools
