#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "mien/core/time.h"
#include "mien/imu/calibration.h"
#include "mien/imu/prologue.h"
#include "mien/sensor/rig.h"

namespace mien::imu {

/// Watches a wearer who has no calibration for a still face, a nod and a shake, and makes one of them: the
/// first second of stillness is neutral until a nod follows. A shake that follows the nod adds its score.
/// Nothing else that a head does calibrates; a nod that does not do is said in hint(). Fed with one frame of
/// the grid after the other. Thread: one at a time; allocates where a nod has ended.
class SelfCalibration {
 public:
  explicit SelfCalibration(const sensor::Rig& rig);

  enum class Outcome {
    nothing,
    calibrated,  ///< solution() is a new calibration: a nod was good.
    judged,      ///< solution() has the shake's score besides.
  };
  /// `frame.face[i].rate_rad_s` is needed; frames without the ear sensor are not given.
  Outcome add(DeviceTime time, const Prologue::Frame& frame);
  [[nodiscard]] const Calibration& solution() const { return solution_; }

  /// Begins anew, as if nothing had been seen: the ear sensor is another one.
  void forget();

  /// What is waited for, or runs: "neutral", "nod", "shake".
  [[nodiscard]] std::string_view step() const;
  [[nodiscard]] std::string_view hint() const { return hint_; }
  /// The wearer may well be holding still: fusion looks for rest.
  [[nodiscard]] bool expects_rest() const { return state_ == State::restless || state_ == State::holding; }
  /// After a nod was good a shake is waited for; then all is said.
  [[nodiscard]] bool finished() const { return state_ == State::finished; }

  struct Span {
    DeviceTime begin, end;
  };
  /// When the steps of solution() were: neutral, nod, shake (empty when none came).
  [[nodiscard]] const std::array<Span, 3>& spans() const { return spans_; }

 private:
  enum class State { restless, holding, nodding, nodded, shaking, finished };
  void measure(const Prologue::Frame& frame, double dt_s);
  void hold(DeviceTime time, const Prologue::Frame& frame, double dt_s);
  Outcome end_nod(DeviceTime time);
  void begin_shake(DeviceTime time);
  void restart();

  Prologue prologue_;  // Its hold is the one that counts.
  Prologue next_;      // A hold that began later, for those who sit still for minutes.
  Calibration solution_;
  std::array<Span, 3> spans_{};
  State state_ = State::restless;
  std::string_view hint_;
  std::optional<DeviceTime> last_;
  double head_rate_ = 0;  // Smoothed, rad/s.
  double face_rate_ = 0;  // Median of the face's sensors, smoothed.
  double still_s_ = 0;
  double hold_s_ = 0;
  double next_s_ = -1;  // Below 0: not begun.
  double segment_s_ = 0;
  double calm_s_ = 0;
  double farthest_ = 0;               // Of the head from the hold, in this nod, rad.
  Quat hold_ear_ = Quat::Identity();  // The head at the hold's end.
  std::vector<double> rates_;
};

}  // namespace mien::imu
