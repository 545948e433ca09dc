#pragma once

#include <array>
#include <cstddef>

#include "mien/face/output_frame.h"
#include "mien/shaping/frame_parts.h"

namespace mien::shaping {

/// A critically damped spring that begins at rest has 5 % of its way left at this many of its time constants:
/// (1 + x) exp(-x) = 0.05.
inline constexpr double kConstantsTo5Percent = 4.744;

/// How what is shown goes over to another source without a jump: the difference of the two is taken and then
/// let go as by a critically damped spring that begins at rest, and is *added* to the new source's frames, so
/// that the face's own movement shows at once. Part by part: each shape, the tongue, the head and the eyes
/// are taken and let go by themselves. The largest step a 60 Hz frame besides the face's own is 0.03 s over
/// `return_s` of the difference: 0.1 of it with 0.3 s.
/// On frame time; no allocation; frames keep the bits of parts that are not being let go.
class EaseOut {
 public:
  /// Takes the difference of what was `shown` to the `next` source's frame in one part (frame_parts.h). A
  /// part that is still being let go keeps its speed.
  void take(std::size_t part, const face::OutputFrame& shown, const face::OutputFrame& next);
  /// As take, of every part.
  void take_all(const face::OutputFrame& shown, const face::OutputFrame& next);
  /// Adds what is left to the frame, `step_s` after the last; weights stay in [0, 1], eyes within a quarter
  /// turn. After 3 `return_s` a hundred-thousandth is left, and the part is done.
  void apply(face::OutputFrame& frame, double step_s, double return_s);
  /// Some part is being let go.
  [[nodiscard]] bool going() const { return going_count_ > 0; }
  /// Nothing is left of one part, or of any.
  void stop(std::size_t part);
  void stop();

 private:
  // The values of a part: one a shape and of the tongue, 3 of the head (rotation vector, frame W), 4 of the
  // eyes.
  static constexpr std::size_t kHeadValues = kHeadPart;
  static constexpr std::size_t kEyesValues = kHeadValues + 3;
  static constexpr std::size_t kValues = kEyesValues + 4;
  [[nodiscard]] static constexpr std::size_t first_value(std::size_t part) {
    return part < kEyesPart ? part : part == kEyesPart ? kEyesValues : kValues;
  }

  std::array<double, kValues> difference_{};    // What is shown less the source's.
  std::array<double, kValues> speed_{};         // Of the difference, a second.
  std::array<DeviceTime, kPartCount> since_{};  // When the difference was taken.
  std::array<bool, kPartCount> going_{};
  std::size_t going_count_ = 0;
};

}  // namespace mien::shaping
