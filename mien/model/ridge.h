#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"

namespace mien::model {

/// The baseline that every model is measured against: weights linear in one frame of the model's own
/// features.
struct RidgeBaseline {
  std::string profile;        ///< Which sensors it was fitted for: "lab" or "device".
  double penalty = 0;         ///< Chosen on validation; relative to the features' mean square.
  double validation_mse = 0;  ///< On the 53 weights, clipped to [0, 1].
  std::size_t condition = 0;  ///< Numbers a frame that it reads.
  std::size_t outputs = 0;    ///< Weights that it gives.
  std::vector<float> matrix;  ///< outputs x (condition + 1), row-major; the last column is the constant.
  bool operator==(const RidgeBaseline&) const = default;

  /// Weights of one frame, clipped to [0, 1]. Shape: condition.size() == this->condition, out.size() ==
  /// outputs.
  void predict(std::span<const float> condition_frame, std::span<float> out) const;
};

/// Sums up frames and solves for ridges of any penalty: memory does not grow with the frames.
class RidgeFit {
 public:
  RidgeFit(std::size_t condition, std::size_t outputs);

  /// Adds frames. Shape: condition is frames x condition, weights frames x outputs, row-major.
  void add(std::span<const float> condition, std::span<const float> weights);

  /// argmin_M sum |w - M [c; 1]|^2 + penalty * mean square of the centred features * frames * |M|^2, the
  /// constant unpenalised. Errors: bad_usage without frames.
  [[nodiscard]] Result<RidgeBaseline> solve(double penalty) const;
  [[nodiscard]] std::size_t frames() const { return frames_; }

 private:
  std::size_t condition_, outputs_, frames_ = 0;
  Eigen::MatrixXd square_;  ///< (condition + 1)^2: sum of [c; 1][c; 1]^T.
  Eigen::MatrixXd cross_;   ///< (condition + 1) x outputs: sum of [c; 1] w^T.
};

/// Mean squared error on weights clipped to [0, 1]. Shapes as RidgeFit::add.
[[nodiscard]] double mean_squared_error(const RidgeBaseline& ridge, std::span<const float> condition,
                                        std::span<const float> weights);

/// Solves for each penalty of a decade grid (1e-6 to 10) and keeps the one of least error on the validation
/// frames.
[[nodiscard]] Result<RidgeBaseline> choose_ridge(const RidgeFit& fit, std::span<const float> condition,
                                                 std::span<const float> weights);

}  // namespace mien::model
