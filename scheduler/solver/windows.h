#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "scheduler/solver/plan.h"
#include "scheduler/solver/relaxation.h"

namespace muster::scheduler {

/// Exact searches in small windows of a plan: a few UAVs and all that they hold or could take while
/// the others stay as they are.
class Windows {
 public:
  /// All must outlive this; the dual is at the relaxation's prices.
  Windows(const Instance& instance, const Dual& dual, Relaxation* relaxation);

  /// Around each neighbourhood in which the relaxation's solution is not whole.
  void ImproveFractions(Plan* plan, const std::function<bool()>& stop);
  /// Around each UAV that loses against the bound, the greatest loss first.
  void ImproveLosers(Plan* plan, const std::function<bool()>& stop);
  std::int64_t work() const { return work_; }

 private:
  static std::size_t At(std::int32_t i) { return static_cast<std::size_t>(i); }
  /// True when the plan is better.
  bool Improve(Plan* plan, std::vector<std::int32_t> uavs, const std::function<bool()>& stop);
  void Widen(const Plan& plan, std::vector<std::int32_t>* uavs);

  const Instance& instance_;
  const Dual& dual_;
  Relaxation& relaxation_;
  Planner planner_;
  std::int64_t work_ = 0;
  /// Rows of the window's program, -1 where the element is not in it.
  std::vector<std::int32_t> uav_row_, partner_row_, site_row_;
  std::vector<Column> columns_;
};

}  // namespace muster::scheduler
