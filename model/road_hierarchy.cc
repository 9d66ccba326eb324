#include "model/road_hierarchy.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include <Eigen/Core>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include "base/check.h"
#include "base/index.h"

namespace muster {
namespace {

// Loops over costs that lie together in memory, four at a time: vector instructions without asking
// for a newer processor. No cost is more than 2^31 - 1, so sums of two do not overflow.
using Four = std::uint32_t __attribute__((vector_size(16)));

Four FourAt(const std::uint32_t* costs) {
  Four four;
  std::memcpy(&four, costs, sizeof four);
  return four;
}

/// to[i] becomes first + rest[i], where that is less.
void Lower(std::uint32_t* to, std::uint32_t first, const std::uint32_t* rest, std::size_t n) {
  std::size_t i = 0;
  for (; i + 4 <= n; i += 4) {
    const Four old = FourAt(to + i), sum = FourAt(rest + i) + first;
    const Four least = sum < old ? sum : old;
    std::memcpy(to + i, &least, sizeof least);
  }
  for (; i < n; ++i) to[i] = std::min(to[i], first + rest[i]);
}

/// The least of a[i] + b[i], or `least`.
std::uint32_t LeastSum(const std::uint32_t* a, const std::uint32_t* b, std::size_t n,
                       std::uint32_t least) {
  std::size_t i = 0;
  if (n >= 4) {
    Four of_four = {least, least, least, least};
    for (; i + 4 <= n; i += 4) {
      const Four sum = FourAt(a + i) + FourAt(b + i);
      of_four = sum < of_four ? sum : of_four;
    }
    least = std::min({of_four[0], of_four[1], of_four[2], of_four[3]});
  }
  for (; i < n; ++i) least = std::min(least, a[i] + b[i]);
  return least;
}

std::vector<std::int32_t> OrderByDegree(std::size_t n_nodes,
                                        std::span<const RoadHierarchy::Edge> edges) {
  const auto n = static_cast<Eigen::Index>(n_nodes);
  std::vector<Eigen::Triplet<float, int>> entries;
  entries.reserve(2 * edges.size() + n_nodes);
  // Without a diagonal the order is a bad one.
  for (std::size_t i = 0; i < n_nodes; ++i) {
    const auto node = static_cast<int>(i);
    entries.emplace_back(node, node, 1.0F);
  }
  for (const auto& [a, b] : edges) {
    entries.emplace_back(a, b, 1.0F);
    entries.emplace_back(b, a, 1.0F);
  }
  Eigen::SparseMatrix<float, Eigen::ColMajor, int> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order(n);
  Eigen::AMDOrdering<int>()(matrix, order);
  return {order.indices().data(), order.indices().data() + n_nodes};
}

}  // namespace

RoadHierarchy::RoadHierarchy(std::size_t n_nodes, std::span<const Edge> edges)
    : rank_of_(n_nodes), ranks_(n_nodes) {
  if (n_nodes > 0) {
    const std::vector<std::int32_t> order = OrderByDegree(n_nodes, edges);
    for (std::size_t i = 0; i < n_nodes; ++i) {
      rank_of_[At(order[i])] = static_cast<std::int32_t>(i);
    }
  }
  Number(Contract(edges));
}

std::int32_t RoadHierarchy::RankOf(std::int32_t node) const { return rank_of_[At(node)]; }

/// When a node is contracted, all that it leads up to become neighbours: it is enough to hand them
/// to the first of them.
RoadHierarchy::Heads RoadHierarchy::Contract(std::span<const Edge> edges) const {
  Heads heads_of(ranks_.size());
  for (const auto& [a, b] : edges) {
    const auto [low, high] = std::minmax({RankOf(a), RankOf(b)});
    if (low != high) heads_of[At(low)].push_back(high);
  }
  for (std::vector<std::int32_t>& heads : heads_of) {
    std::sort(heads.begin(), heads.end());
    heads.erase(std::unique(heads.begin(), heads.end()), heads.end());
    if (heads.empty()) continue;
    std::vector<std::int32_t>& of_parent = heads_of[At(heads.front())];
    of_parent.insert(of_parent.end(), heads.begin() + 1, heads.end());
  }
  return heads_of;
}

/// Numbers ranks anew: children before their parent, the child with most below it last. What leads
/// where stays the same.
void RoadHierarchy::Number(Heads heads_of) {
  const std::size_t n = heads_of.size();
  const auto parent_of = [&](std::size_t i) {
    return heads_of[i].empty() ? -1 : heads_of[i].front();
  };
  std::vector<std::int32_t> size(n, 1), largest_child(n, -1);
  for (std::size_t i = 0; i < n; ++i) {
    const std::int32_t parent = parent_of(i);
    if (parent < 0) continue;
    size[At(parent)] += size[i];
    std::int32_t& largest = largest_child[At(parent)];
    if (largest < 0 || size[At(largest)] < size[i]) largest = static_cast<std::int32_t>(i);
  }
  std::vector<std::int32_t> number(n);
  std::vector<std::int32_t> next(n);  // number below which no child of it has begun
  std::int32_t next_root = 0;
  for (std::size_t i = n; i-- > 0;) {
    const std::int32_t parent = parent_of(i);
    const bool is_largest =
        parent >= 0 && largest_child[At(parent)] == static_cast<std::int32_t>(i);
    std::int32_t& begin = parent < 0 ? next_root : next[At(parent)];
    next[i] = is_largest ? number[At(parent)] - size[i] : begin;
    if (!is_largest) begin += size[i];
    number[i] = next[i] + size[i] - 1;
    Rank& rank = ranks_[At(number[i])];
    rank.chain_top = number[i];
    if (parent < 0) continue;
    rank.parent = number[At(parent)];
    rank.depth = InTree(rank.parent).depth + 1;
    if (is_largest) rank.chain_top = InTree(rank.parent).chain_top;
  }
  for (std::int32_t& rank : rank_of_) rank = number[At(rank)];
  std::vector<std::size_t> old_of(n);
  for (std::size_t i = 0; i < n; ++i) old_of[At(number[i])] = i;
  first_ = {0};
  first_.reserve(n + 1);
  for (const std::size_t old : old_of) {
    for (const std::int32_t head : heads_of[old]) heads_.push_back(number[At(head)]);
    first_.push_back(heads_.size());
  }
  runs_.assign(heads_.size(), 1);
  for (std::size_t rank = 0; rank < n; ++rank) {
    for (std::size_t edge = first_[rank + 1]; edge-- > first_[rank] + 1;) {
      if (heads_[edge - 1] + 1 == heads_[edge]) runs_[edge - 1] = runs_[edge] + 1;
    }
  }
}

std::size_t RoadHierarchy::EdgeBetween(std::int32_t low, std::int32_t high) const {
  const auto begin = heads_.begin() + static_cast<std::ptrdiff_t>(FirstEdge(low));
  const auto end = heads_.begin() + static_cast<std::ptrdiff_t>(EndOfEdges(low));
  const auto found = std::lower_bound(begin, end, high);
  MUSTER_CHECK(found != end && *found == high, "ranks {} and {} are no neighbours", low, high);
  return static_cast<std::size_t>(found - heads_.begin());
}

std::size_t RoadHierarchy::NumShared(std::int32_t a, std::int32_t b) const {
  while (InTree(a).chain_top != InTree(b).chain_top) {
    if (InTree(InTree(a).chain_top).depth < InTree(InTree(b).chain_top).depth) std::swap(a, b);
    a = InTree(InTree(a).chain_top).parent;
    if (a < 0) return 0;
  }
  return At(std::min(InTree(a).depth, InTree(b).depth) + 1);
}

RoadCosts::RoadCosts(std::shared_ptr<const RoadHierarchy> hierarchy, std::span<const Arc> arcs)
    : hierarchy_(std::move(hierarchy)),
      up_mm_(hierarchy_->n_edges(), kUnreached),
      down_mm_(hierarchy_->n_edges(), kUnreached) {
  for (const Arc& arc : arcs) {
    const std::int32_t from = hierarchy_->RankOf(arc.from), to = hierarchy_->RankOf(arc.to);
    if (from == to) continue;
    std::uint32_t& cost_mm = from < to ? up_mm_[hierarchy_->EdgeBetween(from, to)]
                                       : down_mm_[hierarchy_->EdgeBetween(to, from)];
    cost_mm = std::min(cost_mm, arc.cost_mm);
  }
  Customize();
}

/// From the lowest rank up: an edge between two ranks costs no more than the way by any lower one
/// that has edges to both.
void RoadCosts::Customize() {
  const RoadHierarchy& tree = *hierarchy_;
  const std::size_t n = tree.n_ranks();
  const auto end_of_ranks = static_cast<std::int32_t>(n);
  // The edges that lead up to each rank.
  std::vector<std::size_t> first(n + 1);
  for (std::size_t edge = 0; edge < tree.n_edges(); ++edge) ++first[At(tree.Head(edge)) + 1];
  for (std::size_t i = 0; i < n; ++i) first[i + 1] += first[i];
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  struct Below {
    std::size_t edge, end;  ///< `end`: of the edges of its lower rank
  };
  std::vector<Below> below(tree.n_edges());
  for (std::int32_t low = 0; low < end_of_ranks; ++low) {
    for (std::size_t edge = tree.FirstEdge(low); edge < tree.EndOfEdges(low); ++edge) {
      below[next[At(tree.Head(edge))]++] = {edge, tree.EndOfEdges(low)};
    }
  }
  std::vector<std::size_t> edge_to(n);  // from this rank; of its heads only
  for (std::int32_t rank = 0; rank < end_of_ranks; ++rank) {
    for (std::size_t edge = tree.FirstEdge(rank); edge < tree.EndOfEdges(rank); ++edge) {
      edge_to[At(tree.Head(edge))] = edge;
    }
    for (std::size_t i = first[At(rank)]; i < first[At(rank) + 1]; ++i) {
      const auto [to_rank, end] = below[i];
      const std::uint32_t there_mm = down_mm_[to_rank], back_mm = up_mm_[to_rank];
      // This rank has edges to all that the lower one has edges to beyond it, so also their runs.
      for (std::size_t beyond = to_rank + 1; beyond < end; beyond += tree.RunFrom(beyond)) {
        const std::size_t edge = edge_to[At(tree.Head(beyond))];
        Lower(&up_mm_[edge], there_mm, &up_mm_[beyond], tree.RunFrom(beyond));
        Lower(&down_mm_[edge], back_mm, &down_mm_[beyond], tree.RunFrom(beyond));
      }
    }
  }
}

RoadCosts::Label RoadCosts::LabelOf(std::span<const End> ends,
                                    const std::vector<std::uint32_t>& by_edge,
                                    std::uint32_t until_mm) const {
  Label label;
  label.until_mm = until_mm;
  for (const End& end : ends) {
    const std::int32_t rank = hierarchy_->RankOf(end.node);
    if (label.rank < 0 || rank < label.rank) label.rank = rank;
  }
  if (label.rank < 0) return label;
  const std::int32_t depth = hierarchy_->InTree(label.rank).depth;
  const auto cost_at = [&](std::int32_t rank) {
    return &label.mm[At(depth - hierarchy_->InTree(rank).depth)];
  };
  label.mm.assign(At(depth) + 1, kUnreached);
  for (const End& end : ends) {
    std::uint32_t& cost_mm = *cost_at(hierarchy_->RankOf(end.node));
    if (end.cost_mm < cost_mm) cost_mm = static_cast<std::uint32_t>(end.cost_mm);
  }
  for (std::int32_t rank = label.rank; rank >= 0; rank = hierarchy_->InTree(rank).parent) {
    const std::uint32_t here_mm = *cost_at(rank);
    if (here_mm == kUnreached || here_mm > until_mm) continue;
    const std::size_t end = hierarchy_->EndOfEdges(rank);
    for (std::size_t edge = hierarchy_->FirstEdge(rank); edge < end;) {
      const std::size_t run = hierarchy_->RunFrom(edge);
      Lower(cost_at(hierarchy_->Head(edge)), here_mm, &by_edge[edge], run);
      edge += run;
    }
  }
  return label;
}

RoadCosts::Label RoadCosts::LabelFrom(std::span<const End> ends, std::uint32_t until_mm) const {
  return LabelOf(ends, up_mm_, until_mm);
}

RoadCosts::Label RoadCosts::LabelTo(std::span<const End> ends, std::uint32_t until_mm) const {
  return LabelOf(ends, down_mm_, until_mm);
}

std::uint32_t RoadCosts::Between(const Label& from, const Label& to) const {
  if (from.rank < 0 || to.rank < 0) return kUnreached;
  const std::size_t n = hierarchy_->NumShared(from.rank, to.rank);
  return LeastSum(from.mm.data() + from.mm.size() - n, to.mm.data() + to.mm.size() - n, n,
                  kUnreached);
}

RoadSearch::RoadSearch(const RoadCosts& costs, const RoadCosts::Label& to)
    : costs_(costs),
      until_mm_(to.until_mm),
      cost_mm_(costs.hierarchy().n_ranks(), RoadCosts::kUnreached),
      is_known_(costs.hierarchy().n_ranks()) {
  std::size_t i = 0;
  for (std::int32_t rank = to.rank; rank >= 0; rank = costs_.hierarchy().InTree(rank).parent) {
    cost_mm_[At(rank)] = to.mm[i++];
  }
}

std::uint32_t RoadSearch::CostFrom(std::int32_t node) {
  const RoadHierarchy& tree = costs_.hierarchy();
  const std::int32_t asked = tree.RankOf(node);
  for (std::int32_t rank = asked; rank >= 0 && !is_known_[At(rank)];
       rank = tree.InTree(rank).parent) {
    unknown_.push_back(rank);
  }
  // All that edges lead up to are ancestors: their costs are known when a rank's turn comes.
  for (; !unknown_.empty(); unknown_.pop_back()) {
    const std::int32_t rank = unknown_.back();
    std::uint32_t least_mm = cost_mm_[At(rank)];
    const std::size_t end = tree.EndOfEdges(rank);
    for (std::size_t edge = tree.FirstEdge(rank); edge < end; edge += tree.RunFrom(edge)) {
      least_mm = LeastSum(&costs_.up_mm()[edge], &cost_mm_[At(tree.Head(edge))], tree.RunFrom(edge),
                          least_mm);
    }
    cost_mm_[At(rank)] = least_mm;
    is_known_[At(rank)] = true;
  }
  return cost_mm_[At(asked)];
}

}  // namespace muster
