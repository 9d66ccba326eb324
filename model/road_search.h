#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <queue>
#include <span>
#include <utility>
#include <vector>

namespace muster {

/// The roads that lead into each node, as a search walks them backwards.
struct RoadGraph {
  struct Arc {
    std::int32_t from;
    std::uint32_t cost_mm;
  };
  std::vector<Arc> arcs;             ///< by the node that they lead to
  std::vector<std::size_t> arcs_of;  ///< [nodes + 1] into arcs

  std::size_t n_nodes() const { return arcs_of.size() - 1; }
};

/// Costs from nodes to one place, found outwards from it as far as was asked: of what Dijkstra's
/// algorithm has reached, all that costs no more than the head of the queue is final.
class RoadSearch {
 public:
  static constexpr std::uint32_t kUnreached = std::numeric_limits<std::uint32_t>::max();

  /// `far`: twice as far as was asked, so that it is seldom taken up again, with room for all nodes
  /// from the beginning. Another grows with what it reaches. `bytes`: of what all searches hold
  /// that were given it.
  RoadSearch(const RoadGraph& graph, bool far, std::shared_ptr<std::atomic<std::size_t>> bytes);
  /// The same on a graph that has all its costs still (StaysWithout).
  RoadSearch(const RoadSearch& all, const RoadGraph& graph,
             std::shared_ptr<std::atomic<std::size_t>> bytes);
  ~RoadSearch() { *bytes_ -= Bytes(); }
  RoadSearch(const RoadSearch&) = delete;
  RoadSearch& operator=(const RoadSearch&) = delete;

  /// A node from which the place is reached at that cost. All of them are told before the first
  /// question.
  void BeginAt(std::int32_t node, std::int64_t cost_mm) { Reach(node, cost_mm); }
  struct Arc {
    std::int32_t from, to;
    std::uint32_t cost_mm;
  };
  /// Whether no cost that was found so far rests on one of these arcs.
  bool StaysWithout(std::span<const Arc> arcs) const;
  /// kUnreached: no way leads from there.
  std::uint32_t CostFrom(std::int32_t node) {
    const std::uint32_t known_mm = CostOf(node);
    return known_mm <= final_mm() ? known_mm : Extend(node);
  }

 private:
  using Entry = std::pair<std::uint32_t, std::int32_t>;  ///< cost, node

  std::uint32_t final_mm() const { return queue_.empty() ? kUnreached : queue_.top().first; }
  std::uint32_t CostOf(std::int32_t node) const;
  std::uint32_t Extend(std::int32_t node);
  void SettleNext();
  void Reach(std::int32_t node, std::int64_t cost_mm);
  /// Where that node is in the table, or would be.
  std::size_t SlotOf(std::int32_t node) const;
  void Widen();
  /// Without the queue.
  std::size_t Bytes() const {
    return cost_mm_.size() * sizeof(std::uint32_t) + table_.size() * sizeof(Entry);
  }

  const RoadGraph& graph_;
  const bool far_;
  const std::shared_ptr<std::atomic<std::size_t>> bytes_;
  std::vector<std::uint32_t> cost_mm_;  ///< by node; empty: the table has them
  std::vector<Entry> table_;            ///< a power of two of slots; node -1: free
  std::size_t n_in_table_ = 0;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

}  // namespace muster
