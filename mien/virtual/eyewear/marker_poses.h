#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "mien/builtin_face/markers.h"
#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/face/profile.h"

namespace mien::virt {

/// How many principal components of marker motion the published study makes its target poses of.
inline constexpr std::size_t kPoseComponents = 6;

/// How long marker motion is measured before an experiment.
inline constexpr double kMeasuredBeforeS = 300;

/// Where a component stands in a target pose.
enum class Level : std::uint8_t { least, origin, most };

/// Target poses as the published study has them: the first principal components of marker motion, measured
/// before the experiment, each at its least, its origin or its most. A component's shape on the model's face
/// is the regression of the weights on the component's score.
class MarkerPoses {
 public:
  /// Captures `seconds` (10 or more) of a virtual performer's expressions, range of motion and speech on the
  /// built-in face. Least and most are the scores' own.
  [[nodiscard]] static Result<MarkerPoses> measure(const builtin_face::MarkerSet& markers, double seconds,
                                                   const Random& random);

  /// Weights of a pose, held to [0, 1]. Shape: kPoseComponents levels.
  [[nodiscard]] face::BlendshapeWeights pose(std::span<const Level> levels) const;
  /// Every component at a level drawn at random.
  [[nodiscard]] face::BlendshapeWeights draw(Random& random) const;
  /// Share of the markers' variance that the components hold.
  [[nodiscard]] double share() const { return share_; }

 private:
  Eigen::VectorXd mean_weights_;
  Eigen::MatrixXd weights_;  ///< kShapeCount x components: weights per unit of score.
  std::vector<std::array<double, 3>> levels_;
  double share_ = 0;
};

}  // namespace mien::virt
