#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "scheduler/solver/dual.h"
#include "scheduler/solver/instance.h"
#include "scheduler/solver/packing_lp.h"
#include "scheduler/solver/plan.h"

namespace muster::scheduler {

/// Up to so many columns, a proof of the optimum is sought.
inline constexpr std::size_t kProofColumns = 20000;
/// Relative gap that is small enough for larger instances.
inline constexpr double kCloseEnough = 1e-6;
/// Relative gap that is small enough for a relaxation that was begun anew: among prices that tie,
/// the last ones take more steps than all before.
inline constexpr double kCloseEnoughAnew = 5e-10;

/// The linear relaxation of the packing, by column generation: the program knows some columns of
/// each UAV; at its prices each UAV's best column overall is found, which bounds the optimum and
/// says what is missing. A program that takes many steps and is still far from its bound is begun
/// anew, once, from a good plan and columns that differ.
class Relaxation {
 public:
  /// Both must outlive this. threads: 1 or 2; no result depends on it.
  Relaxation(const Instance& instance, Dual* dual, int threads);

  /// Solves until no column is missing (in large instances: until those missing count for next to
  /// nothing), or the work limit is reached, or `stop`. While the bound is far above what the
  /// program reaches, `work_limit_if_far` holds in place of a smaller limit. Leaves the dual at the
  /// best prices.
  void Solve(std::int64_t work_limit, const std::function<bool()>& stop,
             std::int64_t work_limit_if_far = 0);

  /// Whether it ended because no column was missing.
  bool solved() const { return solved_; }
  /// Proven: no assignment weighs more.
  double bound() const { return bound_; }
  const Dual::Prices& prices() const { return prices_; }              ///< that prove it
  const Dual::Prices& first_prices() const { return first_prices_; }  ///< nothing but staying
  /// Weight of everybody staying, which the program's objective leaves out.
  double stay_weight() const { return stay_weight_; }
  PackingLp* lp() { return &lp_; }
  const PackingLp& lp() const { return lp_; }
  /// The plan that the program was begun anew from, where it was found hard; none: it was not.
  const std::optional<Plan>& anew() const { return anew_; }
  bool is_hard() const { return lp_.is_hard(); }

  /// What a column of the linear program is.
  struct Known {
    std::int32_t agent;  ///< UAV, or partner on its own
    Column column;
    const Dual::Solo* solo;  ///< null: the UAV's column
  };
  const std::vector<Known>& known() const { return known_; }
  void AddColumn(std::int32_t uav, const Column& column);
  void AddSolo(std::int32_t partner, const Dual::Solo* solo);
  /// Adds every column whose regret at the dual's prices is at most `most`; false when there are
  /// more than `limit`.
  bool AddAll(double most, std::size_t limit);

  /// Adds rows for cliques of the program's columns until its solution violates none, its value is
  /// `enough` or less, or `stop`. Columns are numbered anew.
  void AddCliques(double enough, std::int64_t work_limit, const std::function<bool()>& stop);

  /// What the program's solution uses by more than half; the rest is for Planner::Fill.
  Plan Rounded() const;

  std::int64_t work() const { return lp_.work() + work_; }

 private:
  static std::size_t At(std::int32_t i) { return static_cast<std::size_t>(i); }
  struct Offer {
    double more;  ///< reduced weight above what the UAV earns
    std::int32_t uav;
    Column column;
  };
  /// Columns in an order that differs from UAV to UAV, but for the regret.
  struct Keyed {
    double alike;
    std::uint32_t mix;
    Column column;
    bool operator<(const Keyed& other) const;
  };
  /// How far the bound lies above the program's value.
  double Rest() const { return bound_ - stay_weight_ - lp_.Bound(); }
  /// Whether the program has taken many steps without getting anywhere, so that it must begin anew.
  bool IsHard() const;
  void BeginAnew(const std::function<bool()>& stop);
  void TakePrices();
  /// Orders equal columns, in the same way on every machine.
  std::uint32_t MixOf(std::int32_t uav, const Column& column) const;
  void PairsOf(std::int32_t uav, double most, std::vector<Column>* columns) const;
  std::int64_t Draw(std::int32_t uav, std::vector<Column>* columns,
                    std::vector<Keyed>* drawn) const;
  void AddDiverse(const Plan& plan);
  void OffersOf(std::int32_t uav, std::vector<Column>* columns, std::vector<Offer>* offers) const;
  std::vector<Offer> Offers();
  bool AddOffers(const std::vector<Offer>& offers, const std::function<bool()>& stop,
                 std::int64_t end);

  const Instance& instance_;
  Dual& dual_;
  Planner planner_;
  int threads_;
  PackingLp lp_;
  std::vector<Known> known_;
  std::vector<char> solo_known_;     ///< [n_partner_arcs]
  std::vector<std::int32_t> order_;  ///< UAVs, neighbours close to each other
  Dual::Prices prices_, first_prices_;
  double bound_ = std::numeric_limits<double>::infinity();
  double stay_weight_ = 0;
  bool solved_ = false;
  std::optional<Plan> anew_;
  std::int64_t work_ = 0;
};

}  // namespace muster::scheduler
