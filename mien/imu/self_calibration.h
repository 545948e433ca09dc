#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "mien/core/time.h"
#include "mien/imu/calibration.h"
#include "mien/imu/prologue.h"
#include "mien/sensor/rig.h"
#include "mien/tracker/tracker.h"

namespace mien::imu {

/// Self-calibration: detects a still face, a nod and a shake in the frames of the 60 Hz grid, and calibrates
/// by them (Prologue). A second of stillness is the neutral hold until a nod follows; a shake after the nod
/// adds its score. A nod that fails a check gives hint(). Thresholds: docs/method/calibration.md. Thread: one
/// at a time; allocates where a nod has ended.
class SelfCalibration {
 public:
  explicit SelfCalibration(const sensor::Rig& rig);

  enum class Outcome {
    nothing,
    calibrated,  ///< solution() is a new calibration, by hold and nod.
    judged,      ///< solution() now includes the shake's score.
  };
  /// The next frame, with the ear sensor present and `frame.face[i].rate_rad_s` of each present face sensor.
  Outcome add(DeviceTime time, const Prologue::Frame& frame);
  [[nodiscard]] const Calibration& solution() const { return solution_; }

  /// Resets everything: the ear sensor was replaced.
  void forget();

  /// The step in progress or waited for; none once finished.
  [[nodiscard]] tracker::Step step() const;
  /// Why the last nod was rejected; empty otherwise. A string literal.
  [[nodiscard]] std::string_view hint() const { return hint_; }
  /// Whether the wearer may be holding still: for Fusion::expect_rest().
  [[nodiscard]] bool expects_rest() const { return state_ == State::restless || state_ == State::holding; }
  /// True once the nod was accepted and the shake has come or its time has passed.
  [[nodiscard]] bool finished() const { return state_ == State::finished; }

  /// The steps of solution(): neutral, nod, shake (empty without one).
  using Steps = std::array<tracker::PerformedStep, 3>;
  [[nodiscard]] const Steps& steps() const { return steps_; }

 private:
  static constexpr Steps kNoSteps = {
      {{tracker::Step::neutral, {}, {}}, {tracker::Step::nod, {}, {}}, {tracker::Step::shake, {}, {}}}};
  enum class State { restless, holding, nodding, nodded, shaking, finished };
  void measure(const Prologue::Frame& frame, double dt_s);
  void hold(DeviceTime time, const Prologue::Frame& frame, double dt_s);
  Outcome end_nod(DeviceTime time);
  void begin_shake(DeviceTime time);
  void restart();

  Prologue prologue_;  // With the current hold.
  Prologue next_;      // A later hold, which replaces one that lasts for minutes.
  Calibration solution_;
  Steps steps_ = kNoSteps;
  State state_ = State::restless;
  std::string_view hint_;
  std::optional<DeviceTime> last_;
  double head_rate_ = 0;  // Smoothed, rad/s.
  double face_rate_ = 0;  // Median of the face's sensors, smoothed.
  double still_s_ = 0;
  double hold_s_ = 0;
  double next_s_ = -1;  // Length of the later hold; below 0: none.
  double segment_s_ = 0;
  double settled_s_ = 0;
  double farthest_ = 0;               // Largest angle of the head from the hold in this nod, rad.
  Quat hold_ear_ = Quat::Identity();  // The head at the hold's end.
  std::vector<double> rates_;
};

}  // namespace mien::imu
