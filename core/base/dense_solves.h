// Dense symmetric systems: solutions, factors and eigenvectors. Eigen's routines, compiled here once: each
// costs a compiler two to six seconds in every file that calls it by itself.
#pragma once

#include <Eigen/Cholesky>
#include <optional>

#include "core/base/linalg.h"

namespace likeness {

// x with A x = b by L D L^T with pivoting. a: symmetric, definite or semidefinite; its lower triangle is
// read. Not finite where A is singular and b outside its range: check allFinite().
Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::MatrixXd solve_symmetric_columns(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

// The same of fixed sizes, without memory from the heap. N: 2, 3, 4, 6, 7 or 9.
template <int N>
Eigen::Matrix<double, N, 1> solve_symmetric(const Eigen::Matrix<double, N, N>& a,
                                            const Eigen::Matrix<double, N, 1>& b);

// A symmetric matrix, factored once for several right sides.
class SymmetricFactor {
 public:
  SymmetricFactor() = default;
  explicit SymmetricFactor(const Eigen::MatrixXd& a);
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  Eigen::MatrixXd solve_columns(const Eigen::MatrixXd& b) const;

 private:
  Eigen::LDLT<Eigen::MatrixXd> factor_;
};

// The lower triangular L with A = L L^T (Cholesky), zeros above the diagonal; empty where A is not positive
// definite.
std::optional<Eigen::MatrixXd> cholesky_factor(const Eigen::MatrixXd& a);
// x with L L^T x = b, and x with L^T x = b.
Eigen::VectorXd solve_by_cholesky(const Eigen::MatrixXd& lower, const Eigen::VectorXd& b);
Eigen::VectorXd solve_transposed(const Eigen::MatrixXd& lower, const Eigen::VectorXd& b);

// A = V diag(w) V^T.
struct SymmetricEigen {
  Eigen::VectorXd values;   // w, ascending
  Eigen::MatrixXd vectors;  // V: column k belongs to values[k]; a column's sign is arbitrary
  bool converged = false;
};
SymmetricEigen eigen_of_symmetric(const Eigen::MatrixXd& a);

// Orthonormal columns that span what the columns of `a` span (Householder QR). (rows, columns), rows >=
// columns
Eigen::MatrixXd orthonormal_columns(const Eigen::MatrixXd& a);

}  // namespace likeness
