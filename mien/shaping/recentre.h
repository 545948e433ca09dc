#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "mien/face/output_frame.h"
#include "mien/shaping/centre.h"

namespace mien::shaping {

/// Makes the performer's present face neutral and their present heading ahead, within 1.5 s and without
/// training. Over one second of frames that a sensor stood behind, each shape's resting weight is the lower
/// third of what was seen (a blink, or a word, that takes up less than two thirds of the second does not
/// enter); a shape whose rest would be above Centre::kRestAtMost is being performed and keeps the rest that
/// it had. Then w' = (w - rest) / (1 - rest), not below 0: rest is 0 and full is 1. The new rest is eased in
/// over half a second. The head is turned about the vertical so that the mean heading of that second is
/// ahead. On frame time. No allocation. About 30 KB. A centre that is all zero changes no bit.
class Recentre {
 public:
  enum class State : std::uint8_t {
    idle,       ///< Nothing was asked for yet, or it was called off.
    measuring,  ///< Within the second.
    easing,     ///< A new centre is coming into force.
    done,       ///< It is in force.
    failed,     ///< Fewer than half a second of frames had a sensor behind them: nothing was changed.
  };

  void apply(face::OutputFrame& frame);

  /// Measures from the next frame on; while measuring, begins anew.
  void begin();
  /// Stops measuring; changes nothing else.
  void cancel();
  /// Back to the centre before the last change of it; false when there is none. Once.
  bool undo();
  /// Puts a centre in force (an earlier version's), eased like a measured one. What is out of range or not
  /// finite is brought into it.
  void use(const Centre& centre);
  /// The centre that is, or is coming, in force.
  [[nodiscard]] const Centre& centre() const { return target_; }
  [[nodiscard]] State state() const { return state_; }
  /// Of the last measurement: how many shapes were being performed and kept their rest.
  [[nodiscard]] std::size_t performed() const { return performed_; }
  /// For time that ran back: stops measuring and puts the centre wholly in force.
  void settle();

 private:
  static constexpr std::size_t kMostFrames = 128;

  void measure(const face::OutputFrame& frame);
  void ease_on(DeviceTime time);
  void conclude();
  void go_to(const Centre& centre);
  void take_off(face::OutputFrame& frame) const;

  State state_ = State::idle;
  Centre present_;  // As the last frame had it.
  Centre from_;
  Centre target_;
  std::optional<Centre> before_;            // For undo.
  bool easing_ = false;                     // Goes on while the next rest is measured.
  std::optional<DeviceTime> easing_since_;  // None before its first frame.
  std::optional<DeviceTime> measuring_since_;

  std::array<std::array<float, kMostFrames>, face::kShapeCount> seen_{};
  std::size_t frames_ = 0;
  std::size_t headings_ = 0;
  double sum_x_ = 0;  // Of the forward direction's horizontal part, frame W.
  double sum_z_ = 0;
  std::size_t performed_ = 0;
};

}  // namespace mien::shaping
