#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "scheduler/solver/dual.h"
#include "scheduler/solver/instance.h"
#include "scheduler/solver/plan.h"

namespace muster::scheduler {

/// Improves a plan one class at a time: of UAVs, partners and sites two stay together as they are
/// and the third is matched to them anew, by a heaviest bipartite matching. That finds what chains
/// and windows miss where most columns tie: a partner or a site that all are short of is left over,
/// and no UAV loses by it. Source: for the three-index assignment problem Huang and Lim 2006.
/// Memory and time of a matching grow with the arcs that may be used in it.
class Matchings {
 public:
  /// Both must outlive this. threads: 1 or 2; no result depends on it.
  Matchings(const Instance& instance, const Dual& dual, int threads);

  /// Until no class can be matched better, or `stop`; at the dual's prices, which stay as they are.
  void Improve(Plan* plan, const std::function<bool()>& stop);
  std::int64_t work() const { return work_; }

 private:
  static std::size_t At(std::int32_t i) { return static_cast<std::size_t>(i); }
  /// Two of three; -1: the third, or none.
  struct Half {
    std::int32_t uav = -1, partner = -1, site = -1;
  };
  Plan MatchPartners(const Plan& plan);
  Plan MatchSites(const Plan& plan);
  Plan MatchUavs(const Plan& plan, std::uint32_t round);
  void FindRegrets(const Plan& plan);
  double LeastRegret(std::int32_t site, std::int32_t partner_arc) const;
  std::int32_t SiteFor(const Plan& plan, std::int32_t partner, std::uint32_t round);
  Column ColumnOf(std::int32_t uav, std::int32_t partner, std::int32_t site) const;
  /// Weight of the action, -infinity where it is not offered.
  double WeightOf(const Column& column) const;
  /// What a UAV or a partner does of its own accord: goes alone as in the plan, or stays.
  double OwnWeight(const Plan& plan, std::int32_t partner) const;
  void PutIfFree(Plan* plan, std::int32_t uav, const Column& column) const;
  void KeepOwn(const Plan& before, Plan* plan) const;
  /// What a row may be matched to, and what that gains.
  struct Edge {
    std::int32_t column;
    double gain;
  };
  /// The edges of all rows, one after the other; those that gain nothing are left out.
  struct Edges {
    std::vector<std::size_t> begin = {0};
    std::vector<Edge> all = {};
    void Add(std::int32_t column, double gain) {
      if (gain > 0) all.push_back({column, gain});
    }
    void EndRow() { begin.push_back(all.size()); }
  };
  /// Those that add(row, edges) adds.
  template <class Add>
  Edges EdgesOf(std::size_t n_rows, const Add& add) const;
  /// Of each row the column that it is matched to, or -1, for the largest sum of gains. Source:
  /// shortest augmenting paths with potentials (Edmonds and Karp 1972; Tomizawa 1971).
  std::vector<std::int32_t> Match(std::size_t n_columns, const Edges& edges);

  const Instance& instance_;
  const Dual& dual_;
  Planner planner_;
  int threads_;
  ArcsByAgent uav_arcs_, partner_arcs_;
  std::vector<double> regret_;  ///< [n_partner_arcs] LeastRegret where it is known, or NaN
  std::int64_t work_ = 0;
};

}  // namespace muster::scheduler
