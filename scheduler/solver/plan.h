#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "scheduler/solver/dual.h"
#include "scheduler/solver/instance.h"

namespace muster::scheduler {

/// Losses and gains below it do not count.
inline constexpr double kNegligible = 1e-9;

/// A feasible assignment under change: which action holds each agent and site.
struct Plan {
  std::vector<Column> column;            ///< [n_uavs]
  std::vector<std::int32_t> partner_of;  ///< [n_partners] UAV that takes it along, or -1
  std::vector<const Dual::Solo*> own;  ///< [n_partners] its move alone; null: stays or taken along
  std::vector<std::int32_t> free_places;  ///< [n_sites]
  double weight = -std::numeric_limits<double>::infinity();
};

/// What can be done with plans of one instance, judged by the prices of a Dual.
class Planner {
 public:
  /// Both must outlive this.
  Planner(const Instance& instance, const Dual& dual) : instance_(instance), dual_(dual) {}

  Plan Empty() const;
  std::int32_t PartnerOf(const Column& column) const {
    return column.partner_arc < 0 ? -1 : instance_.partner_arcs[At(column.partner_arc)].partner;
  }
  bool IsFree(const Plan& plan, const Column& column) const;
  void Put(Plan* plan, std::int32_t uav, const Column& column) const;
  void Remove(Plan* plan, std::int32_t uav) const;
  double WeightOf(std::int32_t uav, const Column& column) const;
  /// Sets plan->weight.
  void Weigh(Plan* plan) const;
  double Regret(std::int32_t uav, const Column& column) const;
  double OwnRegret(std::int32_t partner, const Dual::Solo* own) const;
  /// A UAV that holds a place at a site, `rather` if it does; -1: only partners on their own.
  std::int32_t HolderOf(const Plan& plan, std::int32_t site, std::int32_t rather) const;
  /// A partner that goes to the site on its own, or -1.
  std::int32_t SoloAt(const Plan& plan, std::int32_t site) const;

  /// Gives UAVs without a column one, by regret, smallest first; one whose column is taken comes
  /// again with its next best. Then the partners that are left, likewise. Returns the steps done.
  std::int64_t Fill(Plan* plan) const;

 private:
  static std::size_t At(std::int32_t i) { return static_cast<std::size_t>(i); }
  const Instance& instance_;
  const Dual& dual_;
};

}  // namespace muster::scheduler
