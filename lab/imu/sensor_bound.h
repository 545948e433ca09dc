#pragma once

#include <Eigen/Core>
#include <vector>

#include "mien/measure/metrics.h"
#include "mien/virtual/imu/skin_site.h"

namespace mien::lab {

/// What a rig can see at best from one frame of orientations: linear, Gaussian, every shape independent
/// beforehand. Posterior covariance C = (H^T H / noise^2 + I / prior^2)^-1, H the rotation (rad) of each site
/// per unit weight.
struct SensorBound {
  double mse = 0;           ///< Mean posterior variance over the 53 shapes.
  measure::MeanStd pve_mm;  ///< All vertices, by sampling errors from N(0, C).
  std::optional<measure::MeanStd> pve_face_mm;
  std::optional<measure::MeanStd> lmk_mm;
  /// Posterior over prior standard deviation, a shape: 1 is unseen, 0 is seen exactly.
  std::array<double, face::kShapeCount> left{};
};

/// The weight at which virt::rotation_slopes() takes the bound's slopes: small enough to be the slope at
/// neutral, large enough for float meshes.
inline constexpr float kBoundStep = 0.05F;

/// C of SensorBound. `slopes`: 3 rows a sensor (rad per unit weight), a column a shape. `prior` and
/// `noise_rad` (per axis) positive.
[[nodiscard]] Eigen::MatrixXd posterior_covariance(const Eigen::MatrixXd& slopes, double prior,
                                                   double noise_rad);

/// The bound of a posterior covariance. 2,000 draws from `random`.
[[nodiscard]] SensorBound bound_of(const measure::Meter& meter, const Eigen::MatrixXd& covariance,
                                   double prior, Random random);

/// `prior` and `noise_rad` (per axis) positive; `sites` those of the face's own sensors. 2,000 draws from
/// `random`.
[[nodiscard]] SensorBound sensor_bound(const measure::Meter& meter, const std::vector<virt::SkinSite>& sites,
                                       double prior, double noise_rad, Random random);

}  // namespace mien::lab
