#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "base/index.h"
#include "scheduler/solver/basis_factors.h"
#include "scheduler/solver/pricing.h"

namespace muster::scheduler {

/// max c x, A x <= b, x >= 0 where every column has up to three ones, and more where it is in
/// cliques: the linear relaxation of a packing of elements. Columns may be added between solves;
/// the basis is kept.
///
/// Primal simplex with the inverse of the basis stored by columns, of which only those of rows
/// whose slack is not basic differ from unit vectors: about two for each UAV of a decision. They
/// are sparse, so what one step costs depends on how far an exchange of agents reaches, not on the
/// size of the whole; one that fills up is kept as an array. What enters is chosen by the largest
/// reduced cost, and once that has taken many steps by devex weights. Right-hand sides are raised
/// by different small amounts against stalling; dual prices do not depend on it. Of the rows that
/// may leave, the one with the largest pivot does (Harris 1973), and the inverse is made anew when
/// it no longer fits the basis. Where the inverse fills up after all, BasisFactors take its place.
class PackingLp {
 public:
  static constexpr std::int32_t kNoRow = -1;

  /// The first so many rows' prices rise first: of rows that are used up alike, these stay so.
  explicit PackingLp(std::span<const std::int32_t> capacity, std::int32_t n_first = 0);

  /// Rows that are kNoRow do not count. Returns the column's number, counting from 0.
  std::int32_t AddColumn(double cost, std::array<std::int32_t, 3> rows,
                         std::vector<std::int32_t> more = {});

  /// To optimality over the columns so far; false when `work_limit` ran out or at `stop`, which is
  /// asked now and then.
  bool Solve(std::int64_t work_limit, const std::function<bool()>& stop);

  /// Whether it took many steps for its size: devex weights choose what enters.
  bool is_hard() const { return devex_.has_value(); }
  void UseDevex() { devex_.emplace(*this, &work_); }
  /// Whether its inverse filled up, so that factors of the basis are used instead.
  bool has_factors() const { return factors_.has_value(); }

  /// Whether values and prices fit the basis up to rounding. If not, both are made anew: Solve
  /// again.
  bool Verify();

  /// What a closed column costs, more than others are worth. Before the first is closed.
  void set_closed_cost(double cost) { closed_cost_ = cost; }
  double cost(std::int32_t column) const { return cost_[At(column)]; }
  /// A closed column cannot be used, as it costs too much.
  void Close(std::int32_t column, bool close);
  bool closed(std::int32_t column) const { return closed_[At(column)] != 0; }
  /// Whether a row must be used up. False when it is so already.
  bool Require(std::int32_t row, bool require);
  /// Bound that the prices prove over the columns so far once solved: sum of capacity * price.
  double Bound() const;

  /// Price of each row, >= 0 up to rounding when solved.
  const std::vector<double>& prices() const { return price_; }
  /// Value of a column in the current basic solution; right-hand sides are off by at most 1e-5.
  double value(std::int32_t column) const;
  const std::array<std::int32_t, 3>& rows(std::int32_t column) const { return rows_[At(column)]; }
  /// That it has beyond these.
  std::span<const std::int32_t> more_rows(std::int32_t column) const {
    if (more_rows_.empty()) return {};
    return more_rows_[At(column)];
  }
  /// Columns of a row, ascending.
  const std::vector<std::int32_t>& columns_at(std::int32_t row) const {
    return columns_at_[At(row)];
  }
  std::int32_t capacity(std::int32_t row) const { return capacity_[At(row)]; }
  std::int32_t n_columns() const { return static_cast<std::int32_t>(cost_.size()); }
  std::int64_t work() const { return work_; }
  std::int64_t pivots() const { return pivots_; }
  /// Of a column, or of a row's slack: ~row.
  double ReducedCost(std::int32_t variable) const;
  bool IsBasic(std::int32_t variable) const {
    return (variable >= 0 ? position_of_[At(variable)] : slack_position_[At(~variable)]) >= 0;
  }

 private:
  struct Entry {
    std::int32_t position;
    double value;
  };
  std::int32_t Entering();
  /// A new variable, or one whose cost changed, may enter.
  void Changed(std::int32_t variable);
  void FillAlpha(std::int32_t variable);
  /// The inverse's row at a position, to inverse_row_.
  void FillInverseRow(std::int32_t position);
  void ChangeCost(std::int32_t position, double change);
  void ChangePrice(std::int32_t row, double change);
  /// Position that the variable in alpha_ takes; -1: none, which is rounding only.
  std::int32_t Leaving() const;
  void Pivot(std::int32_t entering, std::int32_t position, double reduced);
  void UpdateInverse(std::int32_t position, double pivot);
  void UpdateSparse(std::int32_t row, std::int32_t position, double factor);
  double Misfit() const;
  void ResetToSlacks();
  void UseFactorsIfDear();
  void Refactor();
  void MakeInverse();
  bool MakeFactors();

  std::int32_t m_;
  std::vector<std::int32_t> capacity_;
  std::vector<double> cost_;
  std::vector<char> closed_;
  std::vector<double> slack_cost_;  ///< [m] 0, or that of a closed column where the row is required
  std::vector<std::array<std::int32_t, 3>> rows_;
  std::vector<std::vector<std::int32_t>> more_rows_;  ///< [n_columns], or empty: none has any
  std::vector<std::int32_t> position_of_;             ///< [n_columns] in the basis, or -1
  std::vector<std::int32_t> slack_position_;          ///< [m] or -1: the row is active
  std::vector<std::int32_t> basic_;  ///< [m] variable at a position: column or ~row
  std::vector<double> x_;            ///< [m] by position
  std::vector<double> price_;        ///< [m]
  std::vector<double> raised_;       ///< [m] right-hand sides
  /// [m] by row; only those of active rows (whose slack is not basic) are used. No entry is zero.
  std::vector<std::vector<Entry>> inverse_;
  /// [m] in place of these, by position, where there are many; else empty.
  std::vector<std::vector<double>> dense_;
  std::vector<std::int32_t> dense_rows_;
  /// [m] rows whose sparse inverse column has, or had, an entry at the position.
  std::vector<std::vector<std::int32_t>> rows_at_;
  std::vector<double> alpha_;  ///< [m] zero but for alpha_nonzero_
  std::vector<std::int32_t> alpha_nonzero_;
  std::vector<double> alpha_values_;  ///< of these
  InverseRow inverse_row_;
  std::vector<std::int32_t> where_;      ///< [m] -1 between uses
  std::vector<std::int64_t> looked_at_;  ///< [m]
  std::int64_t look_ = 0;
  LargestReducedCost largest_;
  std::optional<Devex> devex_;           ///< in its place, of a program that is not easy
  std::optional<BasisFactors> factors_;  ///< in place of inverse_, likewise
  Sparse vector_{0};                     ///< [m] for these; zero between uses
  std::vector<std::vector<std::int32_t>> columns_at_;  ///< [m]
  double closed_cost_ = 1e4;
  std::int64_t work_ = 0, pivots_ = 0, verified_at_ = 0;
  std::int64_t work_before_ = 0;  ///< work_ when the present kLately pivots began
};

}  // namespace muster::scheduler
