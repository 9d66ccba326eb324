#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "scheduler/solver/packing_lp.h"
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
  /// UAVs, the partners that they could take along and the sites that these could use.
  struct Window {
    struct Item {
      std::int32_t uav, partner, site;   ///< uav or partner -1 where there is none
      double gain;                       ///< over staying
      Column column{};                   ///< with a UAV
      const Dual::Solo* solo = nullptr;  ///< without
    };
    std::vector<std::int32_t> uavs, partners, sites;
    std::vector<Column> held;  ///< of each UAV when the window was opened
    std::vector<std::pair<std::int32_t, const Dual::Solo*>> own;  ///< of partners, likewise
    double before = 0;                                            ///< gain of what was held
    double loss = 0;                                              ///< of what was held, by regret
    std::vector<Item> items;
  };

  void Improve(Plan* plan, std::vector<std::int32_t> uavs, const std::function<bool()>& stop);
  void Widen(const Plan& plan, std::vector<std::int32_t>* uavs);
  Window Open(Plan* plan, std::vector<std::int32_t> uavs);
  void ListColumns(const Plan& plan, std::int32_t u, const Column& held, double loss);
  void AddPartner(Plan* plan, std::int32_t p, Window* window);
  void ListItems(Plan* plan, Window* window);
  PackingLp Program(const Plan& plan, const Window& window);
  std::vector<std::int32_t> Search(const Plan& plan, const Window& window,
                                   const std::function<bool()>& stop);
  /// Puts the chosen items into the plan; an empty choice restores what was held.
  void Close(Plan* plan, const Window& window, const std::vector<std::int32_t>& chosen);

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
