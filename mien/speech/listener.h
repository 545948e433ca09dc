#pragma once

#include "mien/core/time.h"
#include "mien/face/profile.h"
#include "mien/face/shape_region.h"
#include "mien/speech/sound_block.h"
#include "mien/tracker/shape_confidence.h"

namespace mien::speech {

/// Regions that sound tells of: mouth and jaw; and their shapes.
[[nodiscard]] constexpr bool is_heard(face::ShapeRegion region) {
  return region == face::ShapeRegion::mouth || region == face::ShapeRegion::jaw;
}
[[nodiscard]] constexpr bool is_heard(std::size_t shape) {
  return is_heard(face::kShapeRegions[shape]);
}

/// What was heard of the mouth at one moment.
struct Heard {
  DeviceTime time;                  ///< Of the mouth, the sound's clock.
  face::BlendshapeWeights weights;  ///< Shapes of mouth and jaw, 0 to 1; the others 0.
  float tongue = 0;                 ///< Tongue out, 0 to 1.
  float closure = 0;                ///< How far the lips are closed for a P, B or M, 0 to 1.
  float voice = 0;                  ///< Whether somebody speaks, 0 to 1.
};

/// One way from sound to the mouth, block by block. A pure function of the blocks. One stream, one thread.
class Listener {
 public:
  virtual ~Listener() = default;
  /// The next block; `time`: the device time of its first sample. What is known of the mouth from then on;
  /// times rise from call to call. Blocks that were lost between two leave their gap in the times.
  virtual Heard push(DeviceTime time, const Block& block) = 0;
  /// What its answers are to be smoothed by (SpokenMouth), 1/s; 0: not at all.
  [[nodiscard]] virtual double smoothing() const { return 0; }
  /// What its answers are worth, where somebody measured it, by Heard::voice as coverage; null: nobody did.
  [[nodiscard]] virtual const tracker::ShapeConfidence* confidence() const { return nullptr; }
  /// The next block begins anew: nothing was heard before.
  virtual void reset() = 0;
};

}  // namespace mien::speech
