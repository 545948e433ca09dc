#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/units.h"
#include "mien/study/imu/placement/sensor_candidates.h"

namespace mien::study {

/// Shapes that are moved together, for people: brows, eyes, cheeks, mouth, jaw.
inline constexpr std::array<std::string_view, 5> kShapeGroups = {"brows", "eyes", "cheeks", "mouth", "jaw"};
/// Index in kShapeGroups.
[[nodiscard]] std::size_t shape_group(std::size_t shape);

/// What good sites make small: the expectation of a square, tr(G C), C the posterior covariance of the
/// weights.
enum class PlacementObjective : std::uint8_t {
  vertex,  ///< How far the skin's vertices are off, mm^2.
  mse,     ///< Of the 53 weights.
  groups,  ///< Of the weights, each of kShapeGroups counting alike however many shapes it has.
};

/// G of an objective on a face, 53 x 53: the mean over the vertices of the region "skin" (all, where the face
/// has none) of B_v^T B_v, mm^2; or the unit matrix over 53.
[[nodiscard]] Eigen::MatrixXd placement_gram(const face::Face& face, PlacementObjective objective);

struct PlacementSettings {
  double prior = 0.10;             ///< Standard deviation of each weight beforehand, above 0.
  double noise_rad = kRadPerDeg;   ///< Of each orientation, an axis, above 0.
  double apart_m = kModuleApartM;  ///< Chosen sensors are at least so far apart.
  bool one_sided = false;          ///< Each side for itself; else pairs of mirror images and the midline.
  std::size_t most = 16;           ///< Sensors of the largest set.
};

/// tr(G C).
[[nodiscard]] double expected_square(const Eigen::MatrixXd& gram, const Eigen::MatrixXd& covariance);

/// C with one more measurement (Woodbury): C - C h^T (h C h^T + noise^2 I)^-1 h C. `rows`: h, three rows a
/// sensor.
[[nodiscard]] Eigen::MatrixXd told_also(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& rows,
                                        double noise_rad);

/// By what share each candidate alone would make tr(G C) smaller, 0 to 1. Shape of `slopes`: 3 rows a
/// candidate.
[[nodiscard]] std::vector<double> share_told(const Eigen::MatrixXd& gram, const Eigen::MatrixXd& covariance,
                                             const Eigen::MatrixXd& slopes, double noise_rad);

using ShapesLeft = std::array<double, face::kShapeCount>;
/// Posterior over prior standard deviation of each shape: 1 is unseen, 0 is seen exactly.
[[nodiscard]] ShapesLeft shapes_left(const Eigen::MatrixXd& covariance, double prior);

/// The best set of its size that was found.
struct PlacementSet {
  std::vector<std::size_t> chosen;  ///< Candidates, in the order in which they were chosen.
  std::size_t before = 0;           ///< How many of these stood before the last step, of one or two.
  Eigen::MatrixXd covariance;       ///< C of all of them, 53 x 53.
  double square = 0;                ///< tr(G C).
};

/// What sites tell, each alone and greedily together.
struct PlacementBound {
  double square_before = 0;            ///< tr(G C) of nothing but the prior.
  std::vector<double> alone;           ///< Share told of each candidate by itself.
  std::vector<ShapesLeft> alone_left;  ///< What it leaves of each shape.
  std::vector<PlacementSet> sets;      ///< Of 1, 2, ... sensors; sizes that cannot be had are left out.
  [[nodiscard]] const PlacementSet* of_size(std::size_t sensors) const;
};

/// Greedy forward selection. One-sided: each step takes the candidate that makes tr(G C) smallest. Else each
/// set has k sensors on the midline, 0 to 3, and pairs: each step takes the pair or the sensor that gains
/// most a sensor, and the best k of each size is kept. Ties go to the earlier candidate. Errors: bad_usage
/// (no candidate, or none that has a partner). Cost: a fraction of a second for 600 candidates.
[[nodiscard]] Result<PlacementBound> bound_placement(const std::vector<SensorCandidate>& candidates,
                                                     const Eigen::MatrixXd& slopes,
                                                     const Eigen::MatrixXd& gram,
                                                     const PlacementSettings& settings);

}  // namespace mien::study
