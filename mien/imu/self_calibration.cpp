#include "mien/imu/self_calibration.h"

#include <algorithm>
#include <cmath>

#include "mien/core/units.h"

namespace mien::imu {
namespace {

constexpr double kSmoothing_s = 0.1;

// Stillness: a head held still sways at a degree a second, and a gyroscope adds its bias until that is
// estimated.
constexpr double kStillHead = 5 * kRadPerDeg;  // rad/s.
constexpr double kStillFace = 6 * kRadPerDeg;
constexpr double kStill_s = 0.8;  // Before a hold begins: biases are being estimated.
/// Least length of the hold of a calibration, s.
constexpr double kMinHold_s = 0.6;
/// Longest hold, s; a later one, begun after half of it, then takes its place.
constexpr double kMaxHold_s = 10;

// Gestures begin when the head's rate exceeds kOnset, and end when it has been slow and within kBack of the
// hold for kSettled_s.
constexpr double kOnset = 8 * kRadPerDeg;  // rad/s.
constexpr double kBack = 8 * kRadPerDeg;   // From where the hold ended, rad.
constexpr double kSettled_s = 0.25;
constexpr double kMinGesture_s = 0.7;
constexpr double kMaxGesture_s = 12;
constexpr double kWaitForShake_s = 4;
constexpr double kNod = 10 * kRadPerDeg;  // Least amplitude of a nod, rad.
constexpr double kVerticalShare = 0.8;
/// Largest standard deviation of an accepted heading, rad: DriftFilter goes on from it, and its score
/// shows it. Boards without device time reach 4 to 12 degrees in their first seconds; a face that talks
/// during the nod, 20 and more.
constexpr double kUsefulHeading = 15 * kRadPerDeg;

bool turns_about_vertical(const Prologue::Frame& frame) {
  const Vec3 rate = frame.q_world_ear * frame.ear_rate_rad_s;
  return std::abs(rate.y()) > kVerticalShare * rate.norm();
}

const sensor::Score* find(const std::vector<sensor::Score>& scores, std::string_view name) {
  for (const sensor::Score& score : scores)
    if (score.name == name) return &score;
  return nullptr;
}

bool passes(const std::vector<sensor::Score>& scores, std::string_view name) {
  const sensor::Score* score = find(scores, name);
  return score != nullptr && score->pass;
}

}  // namespace

SelfCalibration::SelfCalibration(const sensor::Rig& rig) : prologue_(rig), next_(rig) {
  rates_.reserve(rig.sensors.size());
}

tracker::Step SelfCalibration::step() const {
  using tracker::Step;
  switch (state_) {
    case State::restless:
    case State::holding:
      return hold_s_ < kMinHold_s ? Step::neutral : Step::nod;
    case State::nodding:
      return Step::nod;
    case State::nodded:
    case State::shaking:
      return Step::shake;
    case State::finished:
      break;
  }
  return Step::none;
}

void SelfCalibration::restart() {
  state_ = State::restless;
  still_s_ = hold_s_ = 0;
  next_s_ = -1;
}

void SelfCalibration::forget() {
  restart();
  hint_ = {};
  steps_ = kNoSteps;
  solution_ = {};
  last_.reset();
  head_rate_ = face_rate_ = 0;
  segment_s_ = settled_s_ = farthest_ = 0;
}

void SelfCalibration::measure(const Prologue::Frame& frame, double dt_s) {
  const double share = dt_s / (kSmoothing_s + dt_s);
  head_rate_ += share * (frame.ear_rate_rad_s.norm() - head_rate_);
  rates_.clear();
  for (const Prologue::Frame::Face& face : frame.face)
    if (face.present) rates_.push_back(face.rate_rad_s.norm());
  if (rates_.empty()) return;
  // The median: one faulty sensor must not prevent calibration.
  const auto middle = rates_.begin() + static_cast<std::ptrdiff_t>(rates_.size() / 2);
  std::nth_element(rates_.begin(), middle, rates_.end());
  face_rate_ += share * (*middle - face_rate_);
}

void SelfCalibration::hold(DeviceTime time, const Prologue::Frame& frame, double dt_s) {
  if (hold_s_ == 0) {
    prologue_.begin_neutral();
    steps_[0].begin = time - from_seconds(kStill_s);
  }
  prologue_.add_neutral(frame);
  hold_s_ += dt_s;
  steps_[0].end = time;
  hold_ear_ = frame.q_world_ear;
  if (hold_s_ < kMaxHold_s / 2) return;
  if (next_s_ < 0) {
    next_.begin_neutral();
    next_s_ = 0;
  }
  next_.add_neutral(frame);
  next_s_ += dt_s;
  if (hold_s_ < kMaxHold_s) return;
  prologue_ = next_;
  hold_s_ = next_s_;
  steps_[0].begin = time - from_seconds(2 * hold_s_);
  next_s_ = -1;
}

void SelfCalibration::begin_shake(DeviceTime time) {
  prologue_.begin_shake();
  steps_[2].begin = time;
  segment_s_ = settled_s_ = 0;
  state_ = State::shaking;
}

SelfCalibration::Outcome SelfCalibration::end_nod(DeviceTime time) {
  steps_[1].end = time;
  const Calibration made = prologue_.solve();
  const auto valid = std::ranges::count_if(made.sensors, &SensorCalibration::valid);
  const auto headed = std::ranges::count_if(made.sensors, [](const SensorCalibration& sensor) {
    return sensor.valid && sensor.heading_sigma_rad <= kUsefulHeading;
  });
  if (made.complete && passes(made.scores, "neutral face") && passes(made.scores, "nod") &&
      passes(made.scores, "nod axis") && valid > 0 && 2 * headed >= valid) {
    solution_ = made;
    steps_[2].begin = steps_[2].end = time;
    state_ = State::nodded;
    segment_s_ = 0;
    hint_ = {};
    return Outcome::calibrated;
  }
  const sensor::Score* axis = find(made.scores, "nod axis");
  if (axis != nullptr && !axis->pass) {
    // After a shake a nod may follow at once.
    hint_ = "that was no nod; nod straight down and up";
    state_ = State::holding;
    return Outcome::nothing;
  }
  if (!passes(made.scores, "neutral face")) {
    hint_ = "the face moved; relax it, hold still, then nod";
  } else if (!passes(made.scores, "nod")) {
    hint_ = "the nod was too small; nod by 15 degrees or more";
  } else {
    hint_ = "the face moved while nodding; hold it still, then nod again";
  }
  restart();
  return Outcome::nothing;
}

SelfCalibration::Outcome SelfCalibration::add(DeviceTime time, const Prologue::Frame& frame) {
  const double dt_s = last_ ? std::clamp(to_seconds(time - *last_), 0.0, 0.1) : 0;
  last_ = time;
  measure(frame, dt_s);
  const bool still = head_rate_ < kStillHead && face_rate_ < kStillFace;
  const bool back = head_rate_ < kOnset && hold_ear_.angularDistance(frame.q_world_ear) < kBack;
  settled_s_ = back ? settled_s_ + dt_s : 0;

  switch (state_) {
    case State::restless:
      still_s_ = still ? still_s_ + dt_s : 0;
      if (still_s_ >= kStill_s) {
        state_ = State::holding;
        hold_s_ = 0;
        next_s_ = -1;
      }
      return Outcome::nothing;

    case State::holding:
      if (head_rate_ >= kOnset) {
        if (hold_s_ < kMinHold_s) {
          restart();
          return Outcome::nothing;
        }
        prologue_.begin_nod();
        steps_[1].begin = time;
        segment_s_ = settled_s_ = farthest_ = 0;
        state_ = State::nodding;
      } else if (still) {
        hold(time, frame, dt_s);
      } else if (head_rate_ < kStillHead) {
        restart();  // The face moved while the head was still.
      }
      return Outcome::nothing;

    case State::nodding: {
      prologue_.add_nod(frame);
      segment_s_ += dt_s;
      const double turned = hold_ear_.angularDistance(frame.q_world_ear);
      farthest_ = std::max(farthest_, turned);
      if (segment_s_ >= kMinGesture_s && settled_s_ >= kSettled_s) return end_nod(time);
      // A shake may follow without a rest: the head then turns about the vertical, from where it was.
      if (segment_s_ >= kMinGesture_s && farthest_ >= kNod && turned < kBack && head_rate_ >= kOnset &&
          turns_about_vertical(frame)) {
        const Outcome outcome = end_nod(time);
        if (outcome == Outcome::calibrated) begin_shake(time);
        return outcome;
      }
      if (segment_s_ > kMaxGesture_s) {
        hint_ = "the head kept moving; hold still, then nod";
        restart();
      }
      return Outcome::nothing;
    }

    case State::nodded:
      segment_s_ += dt_s;
      if (head_rate_ >= kOnset) {
        begin_shake(time);
      } else if (segment_s_ > kWaitForShake_s) {
        state_ = State::finished;
      }
      return Outcome::nothing;

    case State::shaking:
      prologue_.add_shake(frame);
      segment_s_ += dt_s;
      if (segment_s_ > kMaxGesture_s) state_ = State::finished;
      if (segment_s_ < kMinGesture_s || settled_s_ < kSettled_s) return Outcome::nothing;
      solution_.scores = prologue_.solve().scores;
      steps_[2].end = time;
      state_ = State::finished;
      return Outcome::judged;

    case State::finished:
      return Outcome::nothing;
  }
  return Outcome::nothing;
}

}  // namespace mien::imu
