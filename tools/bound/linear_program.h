#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace muster::tools {

/// A linear program to which columns are added: the most of the sum of worth * x, where 0 <= x and
/// each row's sum of factor * x is at most the row's limit. Clp's simplex method, whose library
/// is loaded when it is first needed: nothing of ours is linked to it.
class LinearProgram {
 public:
  struct Entry {
    std::int32_t row;
    double factor;
  };

  /// `limits`: of the rows. Throws SystemError when the library is missing, with its Debian
  /// package.
  explicit LinearProgram(std::span<const double> limits);
  ~LinearProgram();
  LinearProgram(const LinearProgram&) = delete;
  LinearProgram& operator=(const LinearProgram&) = delete;

  /// Rows in any order, each once.
  void AddColumn(double worth, std::span<const Entry> entries);
  std::size_t columns() const { return starts_.size() - 1; }

  /// From where it was solved last. Throws SystemError when Clp gives up.
  void Solve();
  double value() const;
  /// Of the rows, not below 0: what one more of the limit would be worth.
  std::vector<double> Prices() const;

 private:
  struct Clp;
  std::unique_ptr<Clp> clp_;
  std::vector<double> limits_, worth_, factors_;
  std::vector<int> starts_ = {0}, rows_;
  std::size_t loaded_ = 0;  ///< columns that Clp has
};

}  // namespace muster::tools
