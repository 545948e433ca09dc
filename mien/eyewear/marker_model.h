#pragma once

#include <Eigen/Core>

#include "mien/core/error.h"

namespace mien::eyewear {

/// How a marker model is fitted.
struct MarkerModelSettings {
  int components =
      20;  ///< Principal components at most, >= 1; fewer where there are fewer numbers or samples.
  /// Above 0 and up to 1: components are taken until they hold this share of the variance, `components` at
  /// most. 1 takes `components` of them.
  double share = 1;
};

/// The published method (Asano et al. 2017, sections 3.3 to 3.5): the markers' 3V numbers are the mean and a
/// weighted sum of principal components, each weight a linear function of all sensors, by least squares.
/// Metres, frame H, in and out.
class MarkerModel {
 public:
  /// Shapes: `sensors` samples x sensors (distances, m), `markers` samples x 3V. A sensor that says nothing
  /// new (constant, or the sum of others) gets the least weights that do. Errors: mismatch (rows differ),
  /// bad_usage (fewer samples than sensors + 2; settings), out_of_range (a number that is not finite).
  [[nodiscard]] static Result<MarkerModel> fit(const Eigen::MatrixXd& sensors, const Eigen::MatrixXd& markers,
                                               const MarkerModelSettings& settings = {});

  /// The markers of one sample of distances. Shape: sensors() in, 3V out.
  [[nodiscard]] Eigen::VectorXd markers(const Eigen::VectorXd& sensors) const;

  [[nodiscard]] Eigen::Index sensors() const { return weights_.cols(); }
  [[nodiscard]] Eigen::Index components() const { return basis_.cols(); }
  /// Share of the training markers' variance that its components hold.
  [[nodiscard]] double share() const { return share_; }
  /// The mean markers, 3V.
  [[nodiscard]] const Eigen::VectorXd& mean() const { return mean_; }
  /// 3V x components, orthonormal, by falling variance.
  [[nodiscard]] const Eigen::MatrixXd& basis() const { return basis_; }

 private:
  Eigen::VectorXd mean_;
  Eigen::MatrixXd basis_;
  Eigen::VectorXd constant_;  ///< w_0 of each component.
  Eigen::MatrixXd weights_;   ///< components x sensors: w_1 ... w_D of each component.
  double share_ = 1;
};

}  // namespace mien::eyewear
