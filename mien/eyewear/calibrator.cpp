#include "mien/eyewear/calibrator.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mien::eyewear {

bool SteadyWatch::add(const GridLight& light) {
  if (frames_.empty()) {
    frames_.assign(kFrames, light);
    scatter_.reserve(light.present.size());
  }
  frames_[next_] = light;
  next_ = (next_ + 1) % kFrames;
  count_ = std::min(count_ + 1, kFrames);
  return count_ == kFrames && steady();
}

bool SteadyWatch::steady() const {
  const std::size_t sensors = frames_.front().present.size();
  scatter_.clear();
  for (std::size_t i = 0; i < sensors; ++i) {
    double sum = 0, square = 0;
    bool there = true;
    for (const GridLight& light : frames_) {
      there = there && light.present[i] != 0;
      sum += light.log_light[i];
      square += light.log_light[i] * light.log_light[i];
    }
    const double mean = sum / kFrames;
    if (there) scatter_.push_back(std::sqrt(std::max(0.0, square / kFrames - mean * mean)));
  }
  if (scatter_.empty() || 2 * scatter_.size() < sensors) return false;
  const auto middle = scatter_.begin() + static_cast<std::ptrdiff_t>(scatter_.size() / 2);
  std::nth_element(scatter_.begin(), middle, scatter_.end());
  return *middle <= kSteady;
}

Calibrator::Calibrator(const sensor::Rig& rig) : names_(photo_sensor_names(rig)), maker_(rig) {}

void Calibrator::guide(StretchKind kind, DeviceTime begin, DeviceTime end) {
  if (stretches_.empty()) {
    before_ = in_force_;
    found_before_ = found_;
    maker_.reset();
  }
  stretches_.push_back({kind, begin, end});
  hint_ = {};
}

void Calibrator::cancel() {
  if (guided()) fall_back();
}

void Calibrator::fall_back() {
  stretches_.clear();
  in_force_ = before_;
  found_ = found_before_;
}

void Calibrator::put_in_force(Normalisation made) {
  in_force_ = std::move(made);
  found_.reset();
  steady_.reset();
}

Calibrator::Change Calibrator::add(DeviceTime frame, const GridLight& light) {
  if (!stretches_.empty()) return lead(frame, light);
  return in_force_.complete ? Change::none : watch(frame, light);
}

Calibrator::Change Calibrator::lead(DeviceTime frame, const GridLight& light) {
  Change change = Change::none;
  // Stretches that end at this frame are finished before others begin; a failure ends all.
  for (std::size_t i = 0; i < stretches_.size();) {
    if (frame < stretches_[i].end) {
      ++i;
      continue;
    }
    const Stretch over = stretches_[i];
    stretches_.erase(stretches_.begin() + static_cast<std::ptrdiff_t>(i));
    change = finish(over);
  }
  for (Stretch& stretch : stretches_) {
    if (frame < stretch.begin) continue;
    if (!std::exchange(stretch.begun, true)) maker_.begin(stretch.kind);
    maker_.add(stretch.kind, light);
  }
  return change;
}

Calibrator::Change Calibrator::finish(const Stretch& stretch) {
  Normalisation made = maker_.solve(in_force_);
  if (stretch.begun && made.complete) {
    put_in_force(std::move(made));
    return Change::calibrated;
  }
  hint_ = "fewer than half of the sensors sent all through the hold; check them and calibrate again";
  fall_back();
  return Change::withdrawn;
}

Calibrator::Change Calibrator::watch(DeviceTime frame, const GridLight& light) {
  if (!steady_.add(light)) return Change::none;
  maker_.reset();
  maker_.begin(StretchKind::neutral);
  for (std::size_t i = 0; i < SteadyWatch::kFrames; ++i) maker_.add(StretchKind::neutral, steady_.frame(i));
  Normalisation made = maker_.solve(in_force_);
  if (!made.complete) return Change::none;
  for (sensor::Score& score : made.scores)
    if (score.name == "neutral face")
      score.sentence =
          "found by itself: two seconds of steady light, whatever face that was; a guided "
          "calibration knows better";
  put_in_force(std::move(made));
  found_ = Span{frame - frame_offset(SteadyWatch::kFrames - 1), frame};
  return Change::calibrated;
}

void Calibrator::forget(std::size_t sensor) {
  steady_.reset();
  const auto lose = [sensor](Normalisation& normalisation) {
    if (sensor >= normalisation.sensors.size()) return;
    normalisation.sensors[sensor].valid = false;
    normalisation.complete = std::ranges::any_of(normalisation.sensors, &SensorNormalisation::valid);
  };
  lose(in_force_);
  lose(before_);
}

Result<void> Calibrator::restore(const Normalisation& normalisation) {
  if (!std::ranges::equal(normalisation.sensors, names_, {}, &SensorNormalisation::sensor))
    return fail(ErrorCode::mismatch, "the calibration is of another rig's sensors", "calibration",
                "calibrate anew");
  cancel();
  put_in_force(normalisation);
  return {};
}

bool Calibrator::wants_neutral() const {
  return stretches_.empty() ? !in_force_.complete : stretches_.front().kind == StretchKind::neutral;
}

}  // namespace mien::eyewear
