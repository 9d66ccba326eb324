#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "scheduler/solver/plan.h"

namespace muster::scheduler {

/// Ejection chains: "u takes what v holds, v takes what w holds, ..., the last takes what is free".
class Chains {
 public:
  Chains(const Instance& instance, const Dual& dual);

  /// Chains from every UAV that loses against the bound, until none makes the plan better or
  /// `stop`.
  void Improve(Plan* plan, const std::function<bool()>& stop);
  std::int64_t work() const { return work_; }

 private:
  static std::size_t At(std::int32_t i) { return static_cast<std::size_t>(i); }
  /// A UAV in a chain: it is to go, by the column that it then takes; what it held is the next
  /// one's to take.
  struct Link {
    std::int32_t uav;
    std::int32_t parent;  ///< link whose column takes what this UAV holds; -1: the seed
    double loss;          ///< of the chain so far, against the plan
    Column takes;         ///< by the parent
  };
  bool Chain(Plan* plan, std::int32_t seed);
  bool CarryOut(Plan* plan, std::int32_t last, const Column& last_column);
  bool OnChain(std::int32_t link, std::int32_t uav) const;
  bool TakenOnChain(std::int32_t link, const Column& column) const;

  const Instance& instance_;
  const Dual& dual_;
  Planner planner_;
  std::vector<Column> columns_;
  std::vector<Link> links_;
  std::vector<double> label_;  ///< [n_uavs] infinite between chains
  std::vector<std::int32_t> touched_;
  std::int64_t work_ = 0;
};

}  // namespace muster::scheduler
