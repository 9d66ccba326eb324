#pragma once

#include <cstdint>
#include <vector>

namespace muster::tools {

/// Largest flow from a source to a sink in a graph with whole capacities. Source: Dinic 1970.
class MaxFlow {
 public:
  explicit MaxFlow(std::int32_t nodes) : first_(static_cast<std::size_t>(nodes), -1) {}

  void Arc(std::int32_t from, std::int32_t to, std::int32_t capacity);
  /// Once.
  std::int64_t Solve(std::int32_t source, std::int32_t sink);

 private:
  struct Half {
    std::int32_t to;
    std::int32_t next;  ///< of the same node, -1: none
    std::int32_t left;  ///< capacity that is left; the half beside it (index ^ 1) leads back
  };
  bool Layer(std::int32_t source, std::int32_t sink);
  std::int32_t Push(std::int32_t node, std::int32_t sink, std::int32_t most);

  std::vector<std::int32_t> first_;
  std::vector<Half> halves_;
  std::vector<std::int32_t> layer_, current_;
};

}  // namespace muster::tools
