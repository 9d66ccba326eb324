#pragma once

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <span>
#include <vector>

namespace muster {

/// The order in which shortest ways of a network are put together, whatever its arcs cost: the
/// chordal graph and elimination tree of a customizable contraction hierarchy (Dibbelt, Strasser
/// and Wagner, 2016), with nodes of least degree first (Eigen's AMD).
///
/// A node's rank is its place in that order. An edge leads from its lower rank up to its higher
/// one. The parent of a rank is the lowest rank that an edge leads up to; all ranks that edges lead
/// up to are its ancestors. A shortest way leads up from its start to an ancestor that both ends
/// share, and down from there. Ranks are numbered such that edges of one rank mostly lead to ranks
/// that follow one another, so their costs lie together in memory.
class RoadHierarchy {
 public:
  struct Edge {
    std::int32_t a, b;
  };
  /// `edges`: of nodes below `n_nodes`; those from a node to itself and repeats have no effect.
  RoadHierarchy(std::size_t n_nodes, std::span<const Edge> edges);

  struct Rank {
    std::int32_t parent = -1;    ///< -1: none
    std::int32_t depth = 0;      ///< number of ancestors
    std::int32_t chain_top = 0;  ///< highest rank of its chain: ranks that follow one another, each
                                 ///< the parent of the one before it
  };
  std::size_t n_ranks() const { return ranks_.size(); }
  std::int32_t RankOf(std::int32_t node) const;
  const Rank& InTree(std::int32_t rank) const { return ranks_[static_cast<std::size_t>(rank)]; }
  std::size_t n_edges() const { return heads_.size(); }
  /// Indices of the edges that lead up from a rank.
  std::size_t FirstEdge(std::int32_t rank) const { return first_[static_cast<std::size_t>(rank)]; }
  std::size_t EndOfEdges(std::int32_t rank) const { return FirstEdge(rank + 1); }
  /// The rank that an edge leads up to; ascending for the edges of one rank.
  std::int32_t Head(std::size_t edge) const { return heads_[edge]; }
  /// A run: edges of one rank, from `edge` on, to ranks that follow one another. How many they are.
  std::size_t RunFrom(std::size_t edge) const { return runs_[edge]; }
  /// The edge between two ranks, of which the first is the lower and which are neighbours.
  std::size_t EdgeBetween(std::int32_t low, std::int32_t high) const;
  /// How many ancestors two ranks share, where a rank is one of its own.
  std::size_t NumShared(std::int32_t a, std::int32_t b) const;

 private:
  using Heads = std::vector<std::vector<std::int32_t>>;  ///< [ranks], ascending
  Heads Contract(std::span<const Edge> edges) const;
  void Number(Heads heads_of);

  std::vector<std::int32_t> rank_of_;  ///< [nodes]
  std::vector<Rank> ranks_;            ///< [nodes]
  std::vector<std::size_t> first_;     ///< [nodes + 1] into heads_
  std::vector<std::int32_t> heads_;    ///< [edges]
  std::vector<std::uint32_t> runs_;    ///< [edges]
};

/// What shortest ways of a network cost when its arcs cost so much: a hierarchy, customized. Costs
/// are whole millimetres.
class RoadCosts {
 public:
  /// As much as this or more: no way leads there.
  static constexpr std::uint32_t kUnreached = 0x7fffffff;
  struct Arc {
    std::int32_t from, to;  ///< nodes that have an edge in the hierarchy
    std::uint32_t cost_mm;
  };
  RoadCosts(std::shared_ptr<const RoadHierarchy> hierarchy, std::span<const Arc> arcs);

  /// One of the nodes by which a place is reached or left. All those of a place are neighbours.
  struct End {
    std::int32_t node;
    std::int64_t cost_mm;  ///< between the place and the node
  };
  /// Costs between a place and each ancestor of the lowest of its nodes. They are right as far as
  /// ways of at most `until_mm` need them, and may be too high beyond.
  struct Label {
    std::uint32_t until_mm = 0;
    std::int32_t rank = -1;         ///< of that node
    std::vector<std::uint32_t> mm;  ///< [the node and its ancestors], from it up
    std::ptrdiff_t Bytes() const { return std::ssize(mm) * std::ptrdiff_t{sizeof(std::uint32_t)}; }
  };
  Label LabelFrom(std::span<const End> ends, std::uint32_t until_mm) const;
  Label LabelTo(std::span<const End> ends, std::uint32_t until_mm) const;
  /// Cost from the place of `from` to that of `to`. If it is more than `until_mm` of one of them,
  /// it may be too high.
  std::uint32_t Between(const Label& from, const Label& to) const;

  const RoadHierarchy& hierarchy() const { return *hierarchy_; }
  /// [edges] Costs of the shortest ways by lower ranks alone, up to the edges' heads.
  const std::vector<std::uint32_t>& up_mm() const { return up_mm_; }

 private:
  void Customize();
  Label LabelOf(std::span<const End> ends, const std::vector<std::uint32_t>& by_edge,
                std::uint32_t until_mm) const;

  std::shared_ptr<const RoadHierarchy> hierarchy_;
  std::vector<std::uint32_t> up_mm_, down_mm_;  ///< [edges]
};

/// Costs from any nodes to one place, found as they are asked for: RPHAST, lazily (Strasser and
/// Zeitz, 2021). What is more than the label's `until_mm` may be too high.
class RoadSearch {
 public:
  /// `costs` outlives it. `to`: from LabelTo of it.
  RoadSearch(const RoadCosts& costs, const RoadCosts::Label& to);
  /// RoadCosts::kUnreached: no way leads from there.
  std::uint32_t CostFrom(std::int32_t node);
  std::uint32_t until_mm() const { return until_mm_; }
  std::ptrdiff_t Bytes() const {
    return std::ssize(cost_mm_) * std::ptrdiff_t{sizeof(std::uint32_t)};
  }

 private:
  const RoadCosts& costs_;
  const std::uint32_t until_mm_;
  std::vector<std::uint32_t> cost_mm_;  ///< [ranks] of the way, or of one by the goal's ancestors
  std::vector<bool> is_known_;          ///< [ranks]
  std::vector<std::int32_t> unknown_;   ///< empty between questions
};

}  // namespace muster
