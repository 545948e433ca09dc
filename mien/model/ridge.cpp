#include "mien/model/ridge.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace mien::model {
namespace {

using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Eigen::Map<const RowMajor> as_matrix(std::span<const float> values, std::size_t columns) {
  return {values.data(), static_cast<Eigen::Index>(values.size() / columns),
          static_cast<Eigen::Index>(columns)};
}

}  // namespace

void RidgeBaseline::predict(std::span<const float> condition_frame, std::span<float> out) const {
  eigen_assert(condition_frame.size() == condition && out.size() == outputs);
  for (std::size_t o = 0; o < outputs; ++o) {
    const float* row = matrix.data() + o * (condition + 1);
    double sum = row[condition];
    for (std::size_t i = 0; i < condition; ++i) sum += double{row[i]} * double{condition_frame[i]};
    out[o] = static_cast<float>(std::clamp(sum, 0.0, 1.0));
  }
}

RidgeFit::RidgeFit(std::size_t condition, std::size_t outputs)
    : condition_(condition),
      outputs_(outputs),
      square_(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(condition + 1),
                                    static_cast<Eigen::Index>(condition + 1))),
      cross_(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(condition + 1),
                                   static_cast<Eigen::Index>(outputs))) {}

void RidgeFit::add(std::span<const float> condition, std::span<const float> weights) {
  constexpr Eigen::Index kBlock = 1024;
  const auto c = as_matrix(condition, condition_);
  const auto w = as_matrix(weights, outputs_);
  eigen_assert(c.rows() == w.rows());
  for (Eigen::Index at = 0; at < c.rows(); at += kBlock) {
    const Eigen::Index rows = std::min(kBlock, c.rows() - at);
    Eigen::MatrixXd block(rows, c.cols() + 1);
    block.leftCols(c.cols()) = c.middleRows(at, rows).cast<double>();
    block.col(c.cols()).setOnes();
    square_.noalias() += block.transpose() * block;
    cross_.noalias() += block.transpose() * w.middleRows(at, rows).cast<double>();
  }
  frames_ += static_cast<std::size_t>(c.rows());
}

Result<RidgeBaseline> RidgeFit::solve(double penalty) const {
  if (frames_ == 0) return fail(ErrorCode::bad_usage, "there are no frames to fit a ridge to");
  const auto n = static_cast<Eigen::Index>(condition_);
  const auto count = static_cast<double>(frames_);
  // Centred, so that the constant is left out of the penalty.
  const Eigen::VectorXd mean_c = square_.col(n).head(n) / count;
  const Eigen::RowVectorXd mean_w = cross_.row(n) / count;
  Eigen::MatrixXd covariance = square_.topLeftCorner(n, n) / count - mean_c * mean_c.transpose();
  const Eigen::MatrixXd relation = cross_.topRows(n) / count - mean_c * mean_w;
  const double mean_square = std::max(covariance.trace() / static_cast<double>(n), 1e-12);
  // The floor keeps the system solvable where features are constant (a flag that is always 1).
  covariance.diagonal().array() += std::max(penalty, 1e-9) * mean_square;
  const Eigen::MatrixXd slopes = covariance.ldlt().solve(relation);
  const Eigen::RowVectorXd constant = mean_w - mean_c.transpose() * slopes;

  RidgeBaseline ridge;
  ridge.penalty = penalty;
  ridge.condition = condition_;
  ridge.outputs = outputs_;
  ridge.matrix.resize(outputs_ * (condition_ + 1));
  Eigen::Map<RowMajor> matrix(ridge.matrix.data(), static_cast<Eigen::Index>(outputs_), n + 1);
  matrix.leftCols(n) = slopes.transpose().cast<float>();
  matrix.col(n) = constant.transpose().cast<float>();
  return ridge;
}

double mean_squared_error(const RidgeBaseline& ridge, std::span<const float> condition,
                          std::span<const float> weights) {
  const std::size_t frames = weights.size() / ridge.outputs;
  std::vector<float> predicted(ridge.outputs);
  double sum = 0;
  for (std::size_t f = 0; f < frames; ++f) {
    ridge.predict(condition.subspan(f * ridge.condition, ridge.condition), predicted);
    for (std::size_t o = 0; o < ridge.outputs; ++o) {
      const double error =
          double{predicted[o]} - std::clamp(double{weights[f * ridge.outputs + o]}, 0.0, 1.0);
      sum += error * error;
    }
  }
  return frames == 0 ? 0 : sum / static_cast<double>(frames * ridge.outputs);
}

Result<RidgeBaseline> choose_ridge(const RidgeFit& fit, std::span<const float> condition,
                                   std::span<const float> weights) {
  RidgeBaseline best;
  for (int decade = -6; decade <= 1; ++decade) {
    MIEN_TRY_ASSIGN(RidgeBaseline ridge, fit.solve(std::pow(10.0, decade)));
    ridge.validation_mse = mean_squared_error(ridge, condition, weights);
    if (best.matrix.empty() || ridge.validation_mse < best.validation_mse) best = std::move(ridge);
  }
  return best;
}

}  // namespace mien::model
