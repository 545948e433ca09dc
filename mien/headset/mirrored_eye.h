#pragma once

#include <span>
#include <vector>

#include "mien/core/error.h"

namespace mien::headset {

/// Tells an eye that is shown mirrored, as by the other eye's camera or by a rig that turns the view wrongly,
/// by what a network finds in it at rest: a linear discriminant (Fisher 1936) over the features of one view.
struct MirroredEye {
  std::vector<float> weight;  ///< One a feature; empty: nothing is known, and nothing is told.
  float bias = 0;

  /// Log odds that the view is mirrored, by its features; 0 where nothing is known.
  [[nodiscard]] float logit(std::span<const float> features) const;
};

/// Log odds beyond which an eye is said to be mirrored. How often that is right stands in a training's
/// results.
inline constexpr float kSurelyMirrored = 3;

/// By the means of both kinds and their common covariance, of which a hundredth of the mean variance is added
/// to each feature's own. `seen`, `mirrored`: views as the network should see them, and the same mirrored,
/// features of each. Errors: bad_usage (fewer than two of a kind, features of other numbers).
[[nodiscard]] Result<MirroredEye> fit_mirrored_eye(std::span<const std::vector<float>> seen,
                                                   std::span<const std::vector<float>> mirrored);

}  // namespace mien::headset
