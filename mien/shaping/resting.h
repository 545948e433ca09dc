#pragma once

#include <array>
#include <cstddef>

#include "mien/core/streaming_mode.h"
#include "mien/face/output_frame.h"
#include "mien/shaping/blink_peaks.h"
#include "mien/shaping/resting_face.h"

namespace mien::shaping {

/// Streaming calibration: what a tracker answers most of the time for brows, cheeks, nose, smile, ... is
/// taken for the wearer's face at rest, and the furthest that lids which rest otherwise close in blinks for
/// closed (docs/method/shaping.md; after REFA, arXiv 2601.03507, supplement 1.3).
///
/// It learns a shape from frames in which that was measured with a confidence of 0.5 or more: of the newest
/// 30 s of them; from the tenth second on what it learnt is in force, eased in over 2 s, and changes by at
/// most 0.02 a second. Off by default: then no bit changes. On frame time, in rising order. No allocation.
/// 56 KB.
class Resting {
 public:
  /// Takes effect at the next frame, eased over half a second. Switched on it learns anew, from what is in
  /// force.
  void set(bool on);
  /// Learns from the frame, and applies the resting face in place. `frame`: mended.
  void apply(face::OutputFrame& frame);
  /// Puts a resting face in force (an earlier version's), eased in likewise, and learns anew from there.
  /// Values are held to their ranges.
  void use(const RestingFace& face);
  /// Learnt so far; kept while switched off.
  [[nodiscard]] const RestingFace& learnt() const { return learnt_; }
  /// As applied to the last frame.
  [[nodiscard]] const RestingFace& present() const { return present_; }
  /// For time that runs back: ends what is being eased and forgets the last 30 s, not what is in force.
  void reset();

 private:
  static constexpr std::size_t kCalibrated = kRestAtZero.size() + kLids.size();

  struct Ease {
    bool active = false;
    DeviceTime since;
    double length_s = 0;
    float rest = 0;  // As it began.
    float full = 1;
  };

  void learn(std::size_t c, const face::OutputFrame& frame, double step_s);
  void learn_full(std::size_t shape, double most);
  void begin_ease(std::size_t c, DeviceTime time, double length_s);
  void ease_on(std::size_t c, DeviceTime time);
  void forget();

  bool on_ = false;
  bool idle_ = true;      // Off, and nothing is being eased.
  bool changed_ = false;  // Another face or switch since the last frame: to be eased to.
  bool begun_ = false;
  DeviceTime last_;
  RestingFace learnt_;
  RestingFace present_;
  std::array<StreamingMode, kCalibrated> seen_;
  std::array<BlinkPeaks, kLids.size()> blinks_;
  std::array<Ease, kCalibrated> eases_;
};

}  // namespace mien::shaping
