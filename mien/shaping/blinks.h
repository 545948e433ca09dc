#pragma once

#include <array>
#include <optional>

#include "mien/face/blink.h"
#include "mien/face/output_frame.h"

namespace mien::shaping {

/// Blinks of lids that no sensor observes: eyes that never close look dead, and a tracker's guess of them
/// looks asleep. A lid blinks while its eyeBlink is *predicted*, both lids together; *measured*, *held* and
/// *neutral* ones keep their bits.
///
/// Spontaneous blinks come at irregular times, which follow from frame time alone: the same log gives the
/// same blinks, from wherever in it one begins. A fast turn of the head begins one too (Evinger et al. 1994,
/// doi:10.1007/BF00230848), and so does a *measured* eyeSquint that rises fast. Their course is
/// face::Blink's.
///
/// eyeBlink rises towards the blink's weight, eyeWide falls where it is predicted, and the confidence of both
/// falls by the share that is made. On frame time; no allocation.
class Blinks {
 public:
  static constexpr double kRateAtMost = 60;

  /// `rate_per_min`: mean of spontaneous blinks, 0 to kRateAtMost. Raising: eyes close more often. 0: no
  /// blink begins, for no reason at all.
  void apply(face::OutputFrame& frame, double rate_per_min);
  /// Resets the state: a blink under way ends.
  void reset() { *this = Blinks(); }

 private:
  /// Something that rises fast; it begins one blink each time it does.
  struct Cue {
    bool high = false;
    /// Whether `speed` came above `threshold`, for the first time since it was below half of that.
    bool begins(double speed, double threshold);
  };

  [[nodiscard]] bool cued(const face::OutputFrame& frame, double step_s);

  bool begun_ = false;
  face::OutputFrame last_;
  Cue turn_;
  std::array<Cue, 2> squints_;
  std::optional<face::Blink> blink_;  // The last that began.
  std::array<float, 2> share_{};      // 0 to 1, of a blink that each lid shows.
};

}  // namespace mien::shaping
