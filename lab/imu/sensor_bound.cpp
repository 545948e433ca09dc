#include "lab/imu/sensor_bound.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace mien::lab {

Eigen::MatrixXd posterior_covariance(const Eigen::MatrixXd& slopes, double prior, double noise_rad) {
  const Eigen::MatrixXd information =
      slopes.transpose() * slopes / (noise_rad * noise_rad) +
      Eigen::MatrixXd::Identity(slopes.cols(), slopes.cols()) / (prior * prior);
  return information.inverse();
}

SensorBound bound_of(const measure::Meter& meter, const Eigen::MatrixXd& covariance, double prior,
                     Random random) {
  constexpr auto kShapes = static_cast<Eigen::Index>(face::kShapeCount);
  SensorBound bound;
  bound.mse = covariance.trace() / static_cast<double>(kShapes);
  for (Eigen::Index k = 0; k < kShapes; ++k)
    bound.left[static_cast<std::size_t>(k)] = std::sqrt(covariance(k, k)) / prior;

  // Errors around the middle of the range, and made small enough that clipping to [0, 1] does not touch them:
  // distances on the mesh are linear in them.
  constexpr std::size_t kDraws = 2000;
  constexpr double kPriorDrawn = 0.1;  // The middle is five standard deviations from either end.
  const double grow = std::max(1.0, prior / kPriorDrawn);
  const Eigen::MatrixXd root = covariance.llt().matrixL();
  std::vector<face::BlendshapeWeights> truth(kDraws);
  std::vector<face::BlendshapeWeights> estimate(kDraws);
  for (std::size_t d = 0; d < kDraws; ++d) {
    Eigen::VectorXd white(kShapes);
    for (Eigen::Index k = 0; k < kShapes; ++k) white[k] = random.normal();
    const Eigen::VectorXd error = root * white;
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      truth[d][k] = 0.5F;
      estimate[d][k] = 0.5F + static_cast<float>(error[static_cast<Eigen::Index>(k)] / grow);
    }
  }
  const measure::Stretch stretch{truth, estimate};
  const measure::Metrics metrics = meter.measure({&stretch, 1});
  const auto grown = [grow](const measure::MeanStd& value) {
    return measure::MeanStd{grow * value.mean, grow * value.std};
  };
  bound.pve_mm = grown(metrics.pve_mm);
  if (metrics.pve_face_mm) bound.pve_face_mm = grown(*metrics.pve_face_mm);
  if (metrics.lmk_mm) bound.lmk_mm = grown(*metrics.lmk_mm);
  return bound;
}

SensorBound sensor_bound(const measure::Meter& meter, const std::vector<virt::SkinSite>& sites, double prior,
                         double noise_rad, Random random) {
  return bound_of(meter, posterior_covariance(virt::rotation_slopes(sites, kBoundStep), prior, noise_rad),
                  prior, random);
}

}  // namespace mien::lab
