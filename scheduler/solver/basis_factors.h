#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/index.h"

namespace muster::scheduler {

/// Numbers below some limit, each once; in ascending or descending order whatever is added on the
/// way ahead.
class Agenda {
 public:
  explicit Agenda(std::size_t limit) : words_(limit / 64 + 1, 0) {}
  void Add(std::int32_t k) { words_[At(k) / 64] |= std::uint64_t{1} << (At(k) % 64); }
  /// Calls visit(k) for each, which is taken out; visit may add larger ones.
  template <class Visit>
  void TakeUp(Visit&& visit) {
    for (std::size_t w = 0; w < words_.size(); ++w) {
      while (words_[w] != 0) {
        const int bit = std::countr_zero(words_[w]);
        words_[w] &= words_[w] - 1;
        visit(static_cast<std::int32_t>(w * 64) + bit);
      }
    }
  }
  /// Likewise from the largest; visit may add smaller ones.
  template <class Visit>
  void TakeDown(Visit&& visit) {
    for (std::size_t w = words_.size(); w-- > 0;) {
      while (words_[w] != 0) {
        const int bit = 63 - std::countl_zero(words_[w]);
        words_[w] &= ~(std::uint64_t{1} << bit);
        visit(static_cast<std::int32_t>(w * 64) + bit);
      }
    }
  }

 private:
  std::vector<std::uint64_t> words_;
};

/// A vector of which few entries are not 0: `values` is 0 but at `nonzero`, which ascend.
struct Sparse {
  explicit Sparse(std::size_t size) : values(size, 0) {}
  void Clear() {
    for (const std::int32_t i : nonzero) values[At(i)] = 0;
    nonzero.clear();
  }
  std::vector<double> values;
  std::vector<std::int32_t> nonzero;
};

/// The columns of a basis with up to three ones each, as L U times the exchanges since. However
/// full its inverse is, a solution costs what L, U and the exchanges have in the places that it
/// reaches. Source: pivots of least fill among those that are not small (Markowitz 1957; Duff and
/// Reid 1979), exchanges in product form (Dantzig and Orchard-Hays 1954).
class BasisFactors {
 public:
  using Rows = std::array<std::int32_t, 3>;  ///< negative ones do not count

  explicit BasisFactors(std::size_t n_rows);

  /// Of the basis whose column at position i is columns[i] [n_rows]. False: it is singular, up to
  /// rounding.
  bool Factor(std::span<const Rows> columns);

  /// In: a right-hand side by row. Out: the solution of B x = right-hand side, by position.
  void Solve(Sparse* vector);
  /// The same with the transposed basis: in by position, out by row.
  void SolveTransposed(Sparse* vector);

  /// The column at the position is replaced by one of which Solve gives x, by position, which is
  /// not 0 at `nonzero` only.
  void Exchange(std::int32_t position, std::span<const double> x,
                std::span<const std::int32_t> nonzero);

  /// Whether the exchanges cost more than new factors would.
  bool is_long() const { return exchanges_.size() >= kMostExchanges; }
  /// Elementary steps so far.
  std::int64_t work() const { return work_; }

 private:
  struct Entry {
    std::int32_t index;
    double value;
  };
  struct Exchanged {
    std::int32_t position;
    double pivot;
    std::vector<Entry> others;
  };
  /// Entries of all steps, one after the other.
  struct Steps {
    std::vector<std::size_t> begin;
    std::vector<Entry> entries;
    std::span<const Entry> at(std::int32_t step) const {
      return {entries.data() + begin[At(step)], begin[At(step) + 1] - begin[At(step)]};
    }
  };
  class Elimination;

  /// The same entries by the step that `index` says, with the number of their own step.
  Steps Transposed(const Steps& steps) const;
  void UndoExchanges(Sparse* vector);

  static constexpr std::size_t kMostExchanges = 100;

  std::size_t n_;
  /// Of each step the row and the position of its pivot, and the other way round. [n_rows]
  std::vector<std::int32_t> row_, position_, step_of_row_, step_of_position_;
  std::vector<double> pivot_;  ///< [n_rows] by step
  Steps lower_;     ///< what a step's row, times this, is taken from, by row; then by step
  Steps lower_up_;  ///< the same by the row that is changed
  Steps upper_;     ///< the rest of a step's row, by position; then by step
  Steps upper_up_;  ///< the same by the column
  std::vector<Exchanged> exchanges_;
  std::vector<std::vector<std::int32_t>> exchanges_at_;  ///< [n_rows] that have the position
  std::vector<double> by_step_;                          ///< [n_rows] zero between uses
  Agenda steps_, turns_, out_;
  std::int64_t work_ = 0;
};

}  // namespace muster::scheduler
