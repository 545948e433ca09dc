#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "lab/imu/placement/placement_bound.h"
#include "mien/core/error.h"
#include "mien/face/face.h"

namespace mien::lab {

/// How far a sensor is put beside its place.
struct MisplacementRequest {
  double shift_m = 0.005;             ///< Along the skin, above 0.
  std::size_t directions = 8;         ///< Evenly about the normal, 1 or more.
  double turn_rad = 10 * kRadPerDeg;  ///< Of the skin below it: virt::draw_turns() of that angle.
};

/// How much larger the root of tr(G E) becomes, as a share; negative where the other place is the better one.
struct MisplacementCost {
  double mean = 0;  ///< Over all directions.
  double worst = 0;
};

/// What putting one sensor of a set beside its place costs the whole set.
struct SiteMisplacement {
  std::string sensor;
  MisplacementCost shifted;        ///< Off its place, and nobody knows.
  MisplacementCost shifted_known;  ///< The same once the wearer's skin is learnt there.
  MisplacementCost turned;  ///< The skin lies turned about its normal, and nobody knows. Known it costs
                            ///< nothing: the same axes are told, under other names.
  MisplacementCost tilted;  ///< Likewise about two axes in the skin.
};

/// tr(G E) of a linear estimate that believes in slopes H while H' is true: K the gain of H,
/// E = (I - K H') P (I - K H')^T + noise^2 K K^T, P = prior^2 I. With H' = H it is tr(G C).
[[nodiscard]] double mismatched_squared_error(const Eigen::MatrixXd& gram, const Eigen::MatrixXd& believed,
                                              const Eigen::MatrixXd& truth, double prior, double noise_rad);

/// Of each sensor of a set, worn on this face. The sensor's own axes may lie as they will: its neutral takes
/// them out exactly (docs/method/calibration.md); what is turned here is the skin. Errors: those of
/// virt::skin_sites().
[[nodiscard]] Result<std::vector<SiteMisplacement>> misplacement_costs(
    const face::Face& face, const std::vector<SensorCandidate>& set, const Eigen::MatrixXd& gram,
    const PlacementSettings& settings, const MisplacementRequest& request);

}  // namespace mien::lab
