#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lab/imu/placement/sensor_candidates.h"
#include "mien/core/error.h"
#include "mien/core/units.h"
#include "mien/face/face.h"

namespace mien::lab {

// Greedy Bayesian A- or L-optimal design (Chaloner and Verdinelli 1995, doi:10.1214/ss/1177009939) for the
// linear-Gaussian model y = H w + e of one frame: y the rotation vectors of all sensors (frame H, rad), w the
// weights of the face::kShapeCount shapes with prior N(0, prior^2 I), e ~ N(0, noise^2 I). `slopes`: H, three
// rows a sensor, rad per unit weight. `covariance`: C = (H^T H / noise^2 + I / prior^2)^-1, the posterior's.
// `gram`: G, the symmetric weight matrix of the quadratic loss. The criterion is tr(G C), the expected
// squared error: A-optimality where G is a multiple of I, else L-optimality.

/// Shapes that are moved together, for people: brows, eyes, cheeks, mouth, jaw.
inline constexpr std::array<std::string_view, 5> kShapeGroups = {"brows", "eyes", "cheeks", "mouth", "jaw"};
/// Index in kShapeGroups.
[[nodiscard]] std::size_t shape_group(std::size_t shape);

/// Whose squared error is expected: G.
enum class PlacementObjective : std::uint8_t {
  vertex,  ///< The displacement of the skin's vertices, mm^2.
  mse,     ///< The weights.
  groups,  ///< The weights, each of kShapeGroups counting alike however many shapes it has.
};

/// G of an objective on a face, 53 x 53: the mean over the vertices of the region "skin" (all, where the face
/// has none) of B_v^T B_v, mm^2; or the unit matrix over 53; or a diagonal one of trace 1.
[[nodiscard]] Eigen::MatrixXd placement_gram(const face::Face& face, PlacementObjective objective);

struct PlacementSettings {
  double prior = 0.10;             ///< Standard deviation of each weight beforehand, above 0.
  double noise_rad = kRadPerDeg;   ///< Of each orientation, an axis, above 0.
  double apart_m = kModuleApartM;  ///< Chosen sensors are at least so far apart.
  bool one_sided = false;          ///< Each side for itself; else pairs of mirror images and the midline.
  std::size_t most = 16;           ///< Sensors of the largest set.
};

/// C without any sensor: prior^2 I.
[[nodiscard]] Eigen::MatrixXd prior_covariance(double prior);

/// tr(G C).
[[nodiscard]] double expected_squared_error(const Eigen::MatrixXd& gram, const Eigen::MatrixXd& covariance);

/// C after further sensors (Woodbury): C - C h^T (h C h^T + noise^2 I)^-1 h C. `rows`: h, their rows of H.
[[nodiscard]] Eigen::MatrixXd posterior_with(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& rows,
                                             double noise_rad);

/// Relative reduction of tr(G C) by each sensor of `slopes` if it alone were added, 0 to 1.
[[nodiscard]] std::vector<double> error_reductions(const Eigen::MatrixXd& gram,
                                                   const Eigen::MatrixXd& covariance,
                                                   const Eigen::MatrixXd& slopes, double noise_rad);

/// Posterior over prior standard deviation of each shape: 1 is unseen, 0 is seen exactly.
using PosteriorOverPrior = std::array<double, face::kShapeCount>;
[[nodiscard]] PosteriorOverPrior posterior_over_prior(const Eigen::MatrixXd& covariance, double prior);

/// The best set of its size that was found.
struct PlacementSet {
  std::vector<std::size_t> chosen;  ///< Candidates, in the order in which they were chosen.
  Eigen::MatrixXd covariance;       ///< C of all of them, 53 x 53.
  double squared_error = 0;         ///< tr(G C).
};

/// The greedy designs.
struct PlacementBound {
  std::vector<PlacementSet> sets;  ///< Of 1, 2, ... sensors; sizes that cannot be had are left out.
  /// Null where there is none.
  [[nodiscard]] const PlacementSet* of_size(std::size_t sensors) const;
};

/// Greedy forward selection. One-sided: each step takes the candidate that makes tr(G C) smallest. Else each
/// set has k sensors on the midline, 0 to 3, and pairs: each step takes the pair or the sensor that gains
/// most a sensor, and the best k of each size is kept. Ties go to the earlier candidate. Sets are not proven
/// to be the best of their size. `slopes`: three rows a candidate. Errors: bad_usage (no candidate, or none
/// that has a partner). Cost: a fraction of a second for 600 candidates.
[[nodiscard]] Result<PlacementBound> bound_placement(const std::vector<SensorCandidate>& candidates,
                                                     const Eigen::MatrixXd& slopes,
                                                     const Eigen::MatrixXd& gram,
                                                     const PlacementSettings& settings);

}  // namespace mien::lab
