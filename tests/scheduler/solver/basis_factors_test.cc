#include "scheduler/solver/basis_factors.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <string>
#include <vector>

#include "base/random.h"

namespace muster::scheduler {
namespace {

using Rows = BasisFactors::Rows;

/// A basis and the same as a matrix.
struct Basis {
  std::vector<Rows> columns;
  Eigen::MatrixXd matrix;
};

Eigen::VectorXd ColumnOf(const Rows& rows, int n) {
  Eigen::VectorXd column = Eigen::VectorXd::Zero(n);
  for (const std::int32_t r : rows) {
    if (r >= 0) column(r) = 1;
  }
  return column;
}

/// Up to three different rows of n.
Rows Drawn(Random* random, int n) {
  Rows rows = {-1, -1, -1};
  for (std::int32_t& row : rows) {
    const auto r = static_cast<std::int32_t>(random->Below(static_cast<std::uint32_t>(n)));
    if (r != rows[0] && r != rows[1] && random->Below(5) > 0) row = r;
  }
  return rows;
}

/// Columns that are drawn take the place of slacks as long as the basis stays regular.
Basis DrawnBasis(Random* random, int n) {
  Basis basis{std::vector<Rows>(At(n)), Eigen::MatrixXd::Identity(n, n)};
  for (int i = 0; i < n; ++i) basis.columns[At(i)] = {i, -1, -1};
  for (int k = 0; k < 2 * n; ++k) {
    const int i = static_cast<int>(random->Below(static_cast<std::uint32_t>(n)));
    const Rows rows = Drawn(random, n);
    const Eigen::VectorXd before = basis.matrix.col(i);
    const double share = basis.matrix.partialPivLu().solve(ColumnOf(rows, n))(i);
    if (std::abs(share) < 0.05) continue;
    basis.columns[At(i)] = rows;
    basis.matrix.col(i) = ColumnOf(rows, n);
  }
  return basis;
}

void ExpectSolves(BasisFactors* factors, const Eigen::MatrixXd& matrix, Random* random) {
  const auto n = static_cast<int>(matrix.rows());
  for (const bool transposed : {false, true}) {
    Sparse vector(At(n));
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
    for (int i = 0; i < n; ++i) {
      if (random->Below(4) > 0) continue;
      right(i) = random->Uniform(-2, 2);
      vector.values[At(i)] = right(i);
      vector.nonzero.push_back(i);
    }
    transposed ? factors->SolveTransposed(&vector) : factors->Solve(&vector);
    const Eigen::VectorXd expected =
        transposed ? Eigen::VectorXd(matrix.transpose().partialPivLu().solve(right))
                   : Eigen::VectorXd(matrix.partialPivLu().solve(right));
    std::vector<char> listed(At(n), 0);
    for (std::size_t k = 0; k < vector.nonzero.size(); ++k) {
      if (k > 0) {
        ASSERT_LT(vector.nonzero[k - 1], vector.nonzero[k]);
      }
      listed[At(vector.nonzero[k])] = 1;
    }
    for (int i = 0; i < n; ++i) {
      ASSERT_NEAR(vector.values[At(i)], expected(i), 1e-7) << "transposed=" << transposed;
      if (!listed[At(i)]) {
        ASSERT_EQ(vector.values[At(i)], 0);
      }
    }
  }
}

TEST(BasisFactors, SolveAsAMatrixDoesAfterEachExchange) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed, Stream::kPolicy, 0, 0);
    const int n = 1 + static_cast<int>(random.Below(70));
    Basis basis = DrawnBasis(&random, n);
    BasisFactors factors(At(n));
    ASSERT_TRUE(factors.Factor(basis.columns));
    ExpectSolves(&factors, basis.matrix, &random);
    for (int k = 0; k < 40; ++k) {
      const Rows rows = Drawn(&random, n);
      Sparse x(At(n));
      for (const std::int32_t r : rows) {
        if (r < 0) continue;
        x.values[At(r)] = 1;
        x.nonzero.push_back(r);
      }
      factors.Solve(&x);
      const int i = static_cast<int>(random.Below(static_cast<std::uint32_t>(n)));
      if (std::abs(x.values[At(i)]) < 0.05) continue;
      factors.Exchange(i, x.values, x.nonzero);
      basis.columns[At(i)] = rows;
      basis.matrix.col(i) = ColumnOf(rows, n);
      ExpectSolves(&factors, basis.matrix, &random);
    }
    ASSERT_TRUE(factors.Factor(basis.columns));
    ExpectSolves(&factors, basis.matrix, &random);
    EXPECT_GT(factors.work(), 0);
  }
}

TEST(BasisFactors, ASingularBasisIsSaidToBeOne) {
  BasisFactors factors(3);
  EXPECT_FALSE(factors.Factor(std::vector<Rows>{{0, 1, -1}, {0, 1, -1}, {2, -1, -1}}));
  EXPECT_FALSE(factors.Factor(std::vector<Rows>{{0, -1, -1}, {-1, -1, -1}, {2, -1, -1}}));
  // (1 1 0), (0 1 1), (1 0 1) has determinant 2; the next is not what a failed one left.
  EXPECT_TRUE(factors.Factor(std::vector<Rows>{{0, 1, -1}, {1, 2, -1}, {0, 2, -1}}));
  Sparse vector(3);
  vector.values = {1, 0, 0};
  vector.nonzero = {0};
  factors.Solve(&vector);
  EXPECT_EQ(vector.values, (std::vector<double>{0.5, -0.5, 0.5}));
}

}  // namespace
}  // namespace muster::scheduler
