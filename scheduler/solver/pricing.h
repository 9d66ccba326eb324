#pragma once

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "base/index.h"

namespace muster::scheduler {

class PackingLp;

/// A variable of a PackingLp is a column's number, or ~row for the row's slack; or none.
inline constexpr std::int32_t kNoVariable = std::numeric_limits<std::int32_t>::min();
inline constexpr double kReducedCost = 1e-9;  ///< below it a variable does not enter the basis

/// Variables that may enter the basis, each once; some of them may not any more.
class EnteringPool {
 public:
  explicit EnteringPool(std::size_t n_rows) : slack_listed_(n_rows, 0) {}

  void Add(std::int32_t variable) {
    if (variable >= 0 && At(variable) >= column_listed_.size()) {
      column_listed_.resize(At(variable) + 1, 0);
    }
    char& listed = Listed(variable);
    if (listed) return;
    listed = 1;
    variables_.push_back(variable);
  }
  bool empty() const { return variables_.empty(); }
  std::size_t size() const { return variables_.size(); }
  std::int32_t operator[](std::size_t k) const { return variables_[k]; }
  /// The last takes its place.
  void Drop(std::size_t k) {
    Listed(variables_[k]) = 0;
    variables_[k] = variables_.back();
    variables_.pop_back();
  }
  template <class Keep>
  void KeepIf(Keep&& keep) {
    std::erase_if(variables_, [&](std::int32_t variable) {
      if (keep(variable)) return false;
      Listed(variable) = 0;
      return true;
    });
  }

 private:
  char& Listed(std::int32_t variable) {
    return variable >= 0 ? column_listed_[At(variable)] : slack_listed_[At(~variable)];
  }

  std::vector<std::int32_t> variables_;
  std::vector<char> column_listed_, slack_listed_;
};

/// Chooses what enters the basis: the largest reduced cost among a few candidates. Columns are
/// looked at again only where a price fell.
class LargestReducedCost {
 public:
  explicit LargestReducedCost(std::size_t n_rows) : pool_(n_rows), is_cheaper_(n_rows, 0) {}

  /// A new variable, or one whose cost changed.
  void Changed(std::int32_t variable) { pool_.Add(variable); }
  void PriceFell(std::int32_t row);
  void ForgetCandidates() { candidates_.clear(); }
  std::int32_t Entering(const PackingLp& lp, std::int64_t* work);

 private:
  void Refill(const PackingLp& lp, std::int64_t* work);

  std::vector<std::pair<double, std::int32_t>> candidates_;
  /// Every variable that may enter is in pool_, or in a row that is listed in cheaper_.
  EnteringPool pool_;
  std::vector<std::int32_t> cheaper_;  ///< rows whose price fell since their columns were looked at
  std::vector<char> is_cheaper_;       ///< [n_rows]
};

/// A row of the basis's inverse: values by row of the program, after a zero for kNoRow.
struct InverseRow {
  double at(std::int32_t row) const { return values[At(row + 1)]; }

  std::vector<double> values;      ///< [1 + n_rows] zero but for
  std::vector<std::int32_t> rows;  ///< these
};

/// Chooses by devex weights (Harris 1973): the best reduced cost relative to a reference weight,
/// both kept for every column and changed only where a step reaches. A step costs more than one of
/// LargestReducedCost, but where many columns tie far fewer are needed.
class Devex {
 public:
  Devex(const PackingLp& lp, std::int64_t* work);

  /// A new variable, or one that is not basic whose cost changed.
  void Changed(const PackingLp& lp, std::int32_t variable);
  /// A basic variable's cost changed, and prices by `change` times its row of the inverse.
  void BasicCostChanged(const PackingLp& lp, const InverseRow& row, double change,
                        std::int64_t* work);
  /// `entering` took the place of `leaving`; prices changed by reduced / pivot times the row that
  /// the inverse had there.
  void Pivoted(const PackingLp& lp, const InverseRow& row, std::int32_t entering,
               std::int32_t leaving, double reduced, double pivot, std::int64_t* work);
  /// Weights are 1 again.
  void Restart(const PackingLp& lp, std::int64_t* work);
  /// Computes the reduced costs again, because steps add up rounding errors, most of all those of
  /// closed columns.
  void Refresh(const PackingLp& lp, std::int64_t* work);
  std::int32_t Entering(const PackingLp& lp, std::int64_t* work);

 private:
  double& Weight(std::int32_t variable) {
    return variable >= 0 ? column_weight_[At(variable)] : slack_weight_[At(~variable)];
  }
  /// Increase of the objective along a unit of the reference framework, squared; 0: cannot enter.
  double Merit(const PackingLp& lp, std::int32_t variable);
  std::int32_t Best(const PackingLp& lp, std::int64_t* work);
  /// Of all that a change of prices reaches, the reduced cost follows, and the weight is at least
  /// `weight` times the square of its entry in the pivot row.
  void Move(const PackingLp& lp, const InverseRow& row, double by, double weight,
            std::int64_t* work);

  EnteringPool pool_;  ///< every variable that may enter
  std::size_t next_in_pool_ = 0;
  std::int64_t compared_at_ = 0;  ///< work
  std::vector<double> reduced_;   ///< [n_columns] reduced costs of those that are not basic
  std::vector<double> column_weight_, slack_weight_;
  std::vector<std::int64_t> reached_at_;  ///< [n_columns] move
  std::int64_t move_ = 0;
  bool fresh_ = true;  ///< reduced_: not moved since
};

}  // namespace muster::scheduler
