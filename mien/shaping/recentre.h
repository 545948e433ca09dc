#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "mien/face/output_frame.h"
#include "mien/shaping/centre.h"
#include "mien/shaping/resting_face.h"

namespace mien::shaping {

/// Re-centring: the performer's present face becomes neutral and their present heading ahead, within 1.5 s.
/// It is measured over one second; shapes, heading and position each by itself, where they are observed for
/// half of it. Each shape's resting weight is the lower tercile (a blink or word of less than two thirds of
/// the second has no influence); a shape whose rest would be above Centre::kRestAtMost is being performed and
/// keeps its earlier rest. Then w' = max(0, (w - rest) / (1 - rest)). The new centre is eased in over half a
/// second. The head is turned about the vertical by that second's mean heading; its position, where a tracker
/// tells it, counts from that second's mean and is turned likewise. On frame time. No allocation. About 30
/// KB. An all-zero centre changes no bit. Method: docs/method/shaping.md.
class Recentre {
 public:
  enum class State : std::uint8_t {
    idle,       ///< Not begun yet.
    measuring,  ///< Within the second of measurement.
    easing,     ///< A new centre is being eased in.
    done,       ///< The centre is fully in force.
    failed,     ///< Neither shapes nor head were observed for half a second: nothing was changed.
  };

  /// Measures where begun, and applies the centre in place. Frames come in rising order of time.
  void apply(face::OutputFrame& frame) {
    observe(frame);
    take_off(frame, {});
  }
  /// The same in two steps, where a resting face is applied in between: a centre is measured on the tracker's
  /// weights, and of its rests only what the resting face leaves is taken off, so that nothing is subtracted
  /// twice whichever was learnt first.
  void observe(const face::OutputFrame& frame);
  void take_off(face::OutputFrame& frame, const RestingFace& applied) const;

  /// Measures from the next frame on; restarts a measurement in progress.
  void begin();
  /// Puts a centre in force (an earlier version's), eased like a measured one. Values are clamped to their
  /// ranges.
  void use(const Centre& centre);
  /// The centre in force or being eased in.
  [[nodiscard]] const Centre& centre() const { return target_; }
  [[nodiscard]] State state() const { return state_; }
  /// Number of shapes of the last measurement that were being performed and kept their rest.
  [[nodiscard]] std::size_t performed() const { return performed_; }
  /// For time that runs back: stops measuring and ends the ease at once.
  void settle();

 private:
  static constexpr std::size_t kMostFrames = 128;

  void measure(const face::OutputFrame& frame);
  void ease_on(DeviceTime time);
  void conclude();
  void go_to(const Centre& centre);

  State state_ = State::idle;
  Centre present_;  // As applied to the last frame.
  Centre from_;
  Centre target_;
  bool easing_ = false;                     // May continue while the next rest is measured.
  std::optional<DeviceTime> easing_since_;  // None before the ease's first frame.
  std::optional<DeviceTime> measuring_since_;

  std::array<std::array<float, kMostFrames>, face::kShapeCount> seen_{};
  std::size_t frames_ = 0;
  std::size_t headings_ = 0;
  double sum_x_ = 0;  // Of the forward direction's horizontal part, frame W.
  double sum_z_ = 0;
  std::size_t positions_ = 0;
  Vec3 sum_position_m_ = Vec3::Zero();
  std::size_t performed_ = 0;
};

}  // namespace mien::shaping
