#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "mien/face/output_frame.h"
#include "mien/shaping/frame_parts.h"

namespace mien::shaping {

/// Of an offset 5 % are left after this many time constants: offset_left(kConstantsTo5Percent) = 0.05.
inline constexpr double kConstantsTo5Percent = 6.296;
/// The step response of three equal real poles: what is left of an offset that was released at rest, this
/// many time constants later.
[[nodiscard]] inline double offset_left(double constants) {
  return (1 + constants + 0.5 * constants * constants) * std::exp(-constants);
}

/// Crossfade from the frames shown to a new source, without a jump: the offset between the two decays with
/// three equal real poles, so that not even its acceleration jumps, and is *added* to the new source's
/// frames, so that the face's own movement shows at once (inertialisation). Each part (frame_parts.h) has an
/// offset of its own. The largest step per 60 Hz frame, besides the face's own, is 0.03 s / `return_s` of the
/// offset: 0.1 of it with 0.3 s. On frame time; no allocation; parts without an offset keep their bits.
/// Formula: docs/method/shaping.md.
class EaseOut {
 public:
  /// Begins the ease-out of one part: the offset is `shown` less the `next` source's frame, at rest. A part
  /// that is still easing out keeps its speed. Of the head's position only where both know it.
  void begin(std::size_t part, const face::OutputFrame& shown, const face::OutputFrame& next);
  /// Two frames in succession of one face.
  struct Course {
    const face::OutputFrame& before;
    const face::OutputFrame& now;
  };
  /// The same of a source that moved already while another was shown: the offset begins at the last frame,
  /// `now` of both, with the speed that it had there, over `step_s` > 0 from the frame before.
  void begin_moving(std::size_t part, const Course& shown, const Course& next, double step_s);
  /// The same for every part.
  void begin_all(const face::OutputFrame& shown, const face::OutputFrame& next);
  /// Adds the remaining offsets to the frame, `step_s` after the last; weights are clamped to [0, 1], eyes to
  /// kEyeAtMostRad. `return_s`: time to 5 % of the offset, > 0. After three times that, at 1e-6, a part ends.
  void apply(face::OutputFrame& frame, double step_s, double return_s);
  /// Whether any part is easing out.
  [[nodiscard]] bool active() const { return active_count_ > 0; }
  /// Drops the offset of one part, or of all.
  void stop(std::size_t part);
  void stop();

 private:
  // Values per part: one for each shape and the tongue, 3 for the head (rotation vector, frame W), 4 for the
  // eyes, 3 for the head's position (frame W, m).
  static constexpr std::size_t kHeadValues = kHeadPart;
  static constexpr std::size_t kEyesValues = kHeadValues + 3;
  static constexpr std::size_t kPositionValues = kEyesValues + 4;
  static constexpr std::size_t kValues = kPositionValues + 3;
  /// Of one part.
  using PartValues = std::array<double, 4>;
  [[nodiscard]] static PartValues offset_of(std::size_t part, const face::OutputFrame& shown,
                                            const face::OutputFrame& next);
  [[nodiscard]] static constexpr std::size_t first_value(std::size_t part) {
    return part < kEyesPart        ? part
           : part == kEyesPart     ? kEyesValues
           : part == kPositionPart ? kPositionValues
                                   : kValues;
  }

  std::array<double, kValues> difference_{};    // Shown less source.
  std::array<double, kValues> speed_{};         // Of the difference, 1/s.
  std::array<double, kValues> acceleration_{};  // 1/s^2.
  std::array<DeviceTime, kPartCount> since_{};  // Time of begin().
  std::array<bool, kPartCount> active_{};
  std::size_t active_count_ = 0;
};

}  // namespace mien::shaping
