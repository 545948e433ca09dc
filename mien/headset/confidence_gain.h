#pragma once

#include <array>
#include <optional>

#include "mien/face/profile.h"
#include "mien/face/shape_region.h"
#include "mien/headset/answer.h"

namespace mien::headset {

/// How fast weights follow what is found, by the confidence in their region. What was tried:
/// docs/experiments/headset.md, "What is doubted moves little".
struct ConfidenceGainSettings {
  /// From this confidence on weights are what is found. Raising: what is not quite sure moves the face more
  /// slowly, also where it was right.
  float sure = 0.2F;
  /// Down to this one a frame's gain falls to `least`. Raising: what is doubted moves the face less.
  float unsure = 0.05F;
  /// Share of the way to what is found that a frame takes then. Lowering: what is doubted moves the face
  /// less.
  float least = 0.02F;
  /// So many frames ahead a confidence that falls is taken for what it will be, its log odds falling on.
  /// Raising: what comes before a camera is doubted earlier, and so is what merely trembles.
  float lead_frames = 1;
  /// By this share of itself, of a tenth at least, a gain grows a frame. Lowering: the face comes back more
  /// smoothly, and later.
  float growth = 0.3F;
};

/// A low-pass of the first order whose gain falls with the confidence in a region: what is doubted, as while
/// something comes before a camera, moves the face little until the region is given up (shaping::Merge).
/// Brows and eyes pass as they are: a blink is quick, and doubted often. At kFrameRateHz; no allocation.
class ConfidenceGain {
 public:
  explicit ConfidenceGain(const ConfidenceGainSettings& settings = {}) : settings_(settings) {}
  using Confidence = std::array<float, face::kShapeRegionCount>;  ///< Of each region, 0 to 1.
  /// The answer's weights and tongue, which goes with the jaw.
  void apply(const Confidence& confidence, Answer& answer);
  /// The next frame is taken as it is.
  void reset() { last_.reset(); }

 private:
  struct Last {
    face::BlendshapeWeights weights;
    float tongue_out = 0;
    Confidence log_odds{}, gain{};
  };
  ConfidenceGainSettings settings_;
  std::optional<Last> last_;
};

}  // namespace mien::headset
