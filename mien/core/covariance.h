#pragma once

#include <Eigen/Core>
#include <cmath>

namespace mien {

/// Joseph's form of a Kalman filter's covariance update, P <- (I - K H) P (I - K H)^T + K R K^T. For any gain
/// K the result is symmetric to the bit and, but for rounding of its last digits, positive semi-definite; the
/// shorter P - K H P is neither: its antisymmetric rounding error only grows. Shape: P n x n, H m x n, K n x
/// m, R m x m, symmetric. No allocation where the sizes are fixed. Source: Bucy and Joseph 1968, "Filtering
/// for Stochastic Processes with Applications to Guidance".
template <int N, int M>
void update_covariance(Eigen::Matrix<double, N, N>& covariance,
                       const Eigen::Matrix<double, M, N>& observation,
                       const Eigen::Matrix<double, N, M>& gain, const Eigen::Matrix<double, M, M>& noise) {
  Eigen::Matrix<double, N, N> keep = Eigen::Matrix<double, N, N>::Identity();
  keep.noalias() -= gain * observation;
  const Eigen::Matrix<double, N, N> kept = keep * covariance;
  const Eigen::Matrix<double, N, M> weighed = gain * noise;
  covariance.noalias() = kept * keep.transpose();
  covariance.noalias() += weighed * gain.transpose();
  covariance = (0.5 * (covariance + covariance.transpose())).eval();
}

/// Copies the half below the diagonal to the other.
inline void mirror_lower(Eigen::MatrixXd& matrix) {
  for (Eigen::Index column = 1; column < matrix.cols(); ++column)
    for (Eigen::Index row = 0; row < column; ++row) matrix(row, column) = matrix(column, row);
}

/// update_covariance() by one number, for large states: with `spread` = P h and `expected` = h^T P h + noise
/// the best gain is spread / expected, for which Joseph's form is P - spread spread^T / expected: one half is
/// computed and mirrored, so the result is symmetric to the bit. `expected` is above h^T P h by the noise,
/// which keeps it positive.
inline void update_covariance(Eigen::MatrixXd& covariance, const Eigen::VectorXd& spread, double expected) {
  for (Eigen::Index column = 0; column < covariance.cols(); ++column) {
    const double gain = spread[column] / expected;
    const Eigen::Index below = covariance.rows() - column;
    covariance.col(column).tail(below) -= gain * spread.tail(below);
  }
  mirror_lower(covariance);
}

/// Whether the matrix can be a covariance: finite, symmetric to the bit, no variance below zero, no
/// correlation beyond one (by more than rounding). What is not is a defect of the filter that made it.
template <typename Matrix>
[[nodiscard]] bool is_covariance(const Matrix& covariance) {
  constexpr double kRounding = 1e-9;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    if (!(covariance(i, i) >= 0) || !std::isfinite(covariance(i, i))) return false;
    for (Eigen::Index j = 0; j < i; ++j) {
      if (!(covariance(i, j) == covariance(j, i))) return false;
      if (covariance(i, j) * covariance(i, j) > (1 + kRounding) * covariance(i, i) * covariance(j, j))
        return false;
    }
  }
  return true;
}

}  // namespace mien
