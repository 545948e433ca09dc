#pragma once

#include <Eigen/Core>

#include "mien/core/error.h"

namespace mien::eyewear {

/// Settings of the fit; defaults are the published method's.
struct MarkerModelSettings {
  /// Largest number of principal components, >= 1; limited by markers and samples. Raising: finer shapes and
  /// more noise. Lowering: smoother, coarser markers. 20: Asano et al. 2017.
  int components = 20;
  /// Share of the training variance at which components stop, above 0, up to 1; 1 takes all `components`.
  /// Lowering: fewer components.
  double share = 1;
};

/// The published method (Asano et al. 2017, sections 3.3 to 3.5): principal component regression. The
/// markers' 3V coordinates are their mean and a weighted sum of principal components, each weight a linear
/// function of all sensors' distances, by least squares. Metres; markers in frame H.
class MarkerModel {
 public:
  /// Shapes: `sensors` samples x sensors (distances, m), `markers` samples x 3V. Linearly dependent sensors
  /// get the minimum-norm solution. Errors: mismatch (rows differ), bad_usage (fewer samples than sensors +
  /// 2; settings), out_of_range (a number that is not finite).
  [[nodiscard]] static Result<MarkerModel> fit(const Eigen::MatrixXd& sensors, const Eigen::MatrixXd& markers,
                                               const MarkerModelSettings& settings = {});

  /// The markers for one sample of distances. Sizes: sensors() in, 3V out.
  [[nodiscard]] Eigen::VectorXd markers(const Eigen::VectorXd& sensors) const;

  [[nodiscard]] Eigen::Index sensors() const { return weights_.cols(); }
  [[nodiscard]] Eigen::Index components() const { return basis_.cols(); }
  /// Share of the training markers' variance in its components, 0 to 1.
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
