#include "core/base/dense_solves.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace likeness {

Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.ldlt().solve(b);
}

Eigen::MatrixXd solve_symmetric_columns(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.ldlt().solve(b);
}

template <int N>
Eigen::Matrix<double, N, 1> solve_symmetric(const Eigen::Matrix<double, N, N>& a,
                                            const Eigen::Matrix<double, N, 1>& b) {
  return a.ldlt().solve(b);
}
template Eigen::Matrix<double, 2, 1> solve_symmetric<2>(const Eigen::Matrix<double, 2, 2>&,
                                                        const Eigen::Matrix<double, 2, 1>&);
template Eigen::Matrix<double, 3, 1> solve_symmetric<3>(const Eigen::Matrix<double, 3, 3>&,
                                                        const Eigen::Matrix<double, 3, 1>&);
template Eigen::Matrix<double, 4, 1> solve_symmetric<4>(const Eigen::Matrix<double, 4, 4>&,
                                                        const Eigen::Matrix<double, 4, 1>&);
template Eigen::Matrix<double, 6, 1> solve_symmetric<6>(const Eigen::Matrix<double, 6, 6>&,
                                                        const Eigen::Matrix<double, 6, 1>&);
template Eigen::Matrix<double, 7, 1> solve_symmetric<7>(const Eigen::Matrix<double, 7, 7>&,
                                                        const Eigen::Matrix<double, 7, 1>&);
template Eigen::Matrix<double, 9, 1> solve_symmetric<9>(const Eigen::Matrix<double, 9, 9>&,
                                                        const Eigen::Matrix<double, 9, 1>&);

SymmetricFactor::SymmetricFactor(const Eigen::MatrixXd& a) : factor_(a) {}

Eigen::VectorXd SymmetricFactor::solve(const Eigen::VectorXd& b) const { return factor_.solve(b); }

Eigen::MatrixXd SymmetricFactor::solve_columns(const Eigen::MatrixXd& b) const { return factor_.solve(b); }

std::optional<Eigen::MatrixXd> cholesky_factor(const Eigen::MatrixXd& a) {
  const Eigen::LLT<Eigen::MatrixXd> factor(a);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return Eigen::MatrixXd(factor.matrixL());
}

Eigen::VectorXd solve_by_cholesky(const Eigen::MatrixXd& lower, const Eigen::VectorXd& b) {
  Eigen::VectorXd x = b;
  lower.triangularView<Eigen::Lower>().solveInPlace(x);
  lower.adjoint().triangularView<Eigen::Upper>().solveInPlace(x);
  return x;
}

Eigen::VectorXd solve_transposed(const Eigen::MatrixXd& lower, const Eigen::VectorXd& b) {
  return lower.adjoint().triangularView<Eigen::Upper>().solve(b);
}

SymmetricEigen eigen_of_symmetric(const Eigen::MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors(), solver.info() == Eigen::Success};
}

Eigen::MatrixXd orthonormal_columns(const Eigen::MatrixXd& a) {
  return Eigen::HouseholderQR<Eigen::MatrixXd>(a).householderQ() *
         Eigen::MatrixXd::Identity(a.rows(), a.cols());
}

}  // namespace likeness
