#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
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

/// A queue of nodes by cost for a search that never asks for less than it had: a radix heap (Ahuja,
/// Mehlhorn, Orlin and Tarjan 1990). An entry moves at most 32 times, mostly few, and in runs that
/// lie together in memory.
class CostQueue {
 public:
  using Entry = std::pair<std::uint32_t, std::int32_t>;  ///< cost, node

  bool empty() const { return size_ == 0; }
  /// Seldom a cost below that of top(): then all entries move.
  void push(Entry entry) {
    if (entry.first < least_) Lower(entry.first);
    buckets_[BucketOf(entry.first)].push_back(entry);
    ++size_;
    if (size_ == 1) Sort();
  }
  /// One of those of the least cost.
  const Entry& top() const { return buckets_[0].back(); }
  void pop() {
    buckets_[0].pop_back();
    if (--size_ > 0) Sort();
  }

 private:
  std::size_t BucketOf(std::uint32_t cost) const {
    return static_cast<std::size_t>(std::bit_width(cost ^ least_));
  }
  /// Brings those of the least cost into the first bucket.
  void Sort();
  void Lower(std::uint32_t least);

  std::array<std::vector<Entry>, 33> buckets_;  ///< by the highest bit that differs from least_
  std::uint32_t least_ = 0;
  std::size_t size_ = 0;
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
  using Entry = CostQueue::Entry;

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
  CostQueue queue_;
};

}  // namespace muster
