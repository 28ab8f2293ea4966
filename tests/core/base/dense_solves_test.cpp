#include "core/base/dense_solves.h"

#include <gtest/gtest.h>

#include <random>

namespace likeness {
namespace {

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

Eigen::MatrixXd random_definite(Eigen::Index size, unsigned seed) {
  const Eigen::MatrixXd a = random_matrix(size, size + 3, seed);
  return a * a.transpose();
}

TEST(DenseSolves, SolveSystemsOfAnySize) {
  for (const Eigen::Index size : {1, 2, 5, 40, 130}) {
    const Eigen::MatrixXd a = random_definite(size, unsigned(size));
    const Eigen::VectorXd x = random_matrix(size, 1, 7);
    const Eigen::VectorXd b = a * x;
    EXPECT_NEAR((solve_symmetric(a, b) - x).norm(), 0, 1e-7 * x.norm()) << size;
    EXPECT_NEAR((SymmetricFactor(a).solve(b) - x).norm(), 0, 1e-7 * x.norm()) << size;
    const auto lower = cholesky_factor(a);
    ASSERT_TRUE(lower) << size;
    EXPECT_NEAR((solve_by_cholesky(*lower, b) - x).norm(), 0, 1e-7 * x.norm()) << size;
  }
}

TEST(DenseSolves, SolveEveryColumn) {
  const Eigen::MatrixXd a = random_definite(20, 1), x = random_matrix(20, 6, 2);
  EXPECT_TRUE(solve_symmetric_columns(a, a * x).isApprox(x, 1e-8));
  EXPECT_TRUE(SymmetricFactor(a).solve_columns(a * x).isApprox(x, 1e-8));
}

TEST(DenseSolves, FixedSizesAgreeWithAnySize) {
  const auto check = [](auto size) {
    constexpr int n = decltype(size)::value;
    const Eigen::MatrixXd a = random_definite(n, n), b = random_matrix(n, 1, 3);
    const Eigen::Matrix<double, n, n> fixed = a;
    const Eigen::Matrix<double, n, 1> right = b, x = solve_symmetric<n>(fixed, right);
    EXPECT_TRUE(x.isApprox(solve_symmetric(a, Eigen::VectorXd(b)), 1e-9)) << n;
  };
  check(std::integral_constant<int, 2>()), check(std::integral_constant<int, 3>());
  check(std::integral_constant<int, 4>()), check(std::integral_constant<int, 6>());
  check(std::integral_constant<int, 7>()), check(std::integral_constant<int, 9>());
}

TEST(DenseSolves, ReadOnlyTheLowerTriangle) {
  const Eigen::MatrixXd a = random_definite(9, 4);
  Eigen::MatrixXd lower = a;
  lower.triangularView<Eigen::StrictlyUpper>().setConstant(1e6);
  const Eigen::VectorXd b = random_matrix(9, 1, 5);
  EXPECT_EQ(solve_symmetric(a, b), solve_symmetric(lower, b));
}

TEST(DenseSolves, CholeskyFactorIsLowerAndRefusesWhatIsNotDefinite) {
  const Eigen::MatrixXd a = random_definite(12, 6);
  const auto lower = cholesky_factor(a);
  ASSERT_TRUE(lower);
  EXPECT_TRUE((*lower * lower->transpose()).isApprox(a, 1e-12));
  EXPECT_TRUE(lower->isLowerTriangular(0));
  const Eigen::VectorXd b = random_matrix(12, 1, 8);
  EXPECT_TRUE((lower->transpose() * solve_transposed(*lower, b)).isApprox(b, 1e-10));
  EXPECT_FALSE(cholesky_factor(-a));
}

TEST(DenseSolves, EigenvectorsRebuildTheMatrix) {
  const Eigen::MatrixXd a = random_definite(30, 9);
  const SymmetricEigen eigen = eigen_of_symmetric(a);
  ASSERT_TRUE(eigen.converged);
  EXPECT_TRUE((eigen.vectors * eigen.values.asDiagonal() * eigen.vectors.transpose()).isApprox(a, 1e-11));
  for (Eigen::Index k = 1; k < 30; ++k) EXPECT_LE(eigen.values[k - 1], eigen.values[k]);
}

TEST(DenseSolves, OrthonormalColumnsSpanTheSameSpace) {
  const Eigen::MatrixXd a = random_matrix(25, 3, 10), q = orthonormal_columns(a);
  EXPECT_TRUE((q.transpose() * q).isIdentity(1e-12));
  EXPECT_TRUE((q * (q.transpose() * a)).isApprox(a, 1e-12));
}

}  // namespace
}  // namespace likeness
