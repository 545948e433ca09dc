#include "mien/eyewear/eyewear_tracker.h"

#include <algorithm>
#include <utility>

namespace mien::eyewear {
namespace {

using tracker::Step;

/// Duration of the neutral hold for glasses not worn before, and for remounted ones. Ten seconds instead of
/// three took 31 % off the weights' squared error and 15 % off the vertices' (docs/experiments/eyewear.md).
constexpr Duration kFirstWorn = std::chrono::seconds(10);
constexpr Duration kRemounted = std::chrono::seconds(5);

/// Longest time between frames that drift and the solver's smoothing are given, s.
constexpr double kLongestStepS = 1;

}  // namespace

Result<std::unique_ptr<EyewearTracker>> EyewearTracker::create(const sensor::Rig& rig, MarkedFace face,
                                                               std::unique_ptr<MarkerRegressor> regressor) {
  if (photo_sensors(rig).empty())
    return fail(ErrorCode::mismatch, "the rig has no photo-reflective sensors", rig.name);
  MIEN_TRY_ASSIGN(LightModel model, LightModel::create(std::move(face), std::move(regressor)));
  return std::unique_ptr<EyewearTracker>(new EyewearTracker(rig, std::move(model)));
}

EyewearTracker::EyewearTracker(const sensor::Rig& rig, LightModel model)
    : sensors_(photo_sensors(rig)), grid_(rig), calibrator_(rig), drift_(rig), model_(std::move(model)) {
  features_.values.resize(sensors_.size());
  features_.present.resize(sensors_.size());
}

void EyewearTracker::add(HostTime, const sensor::Sample& sample) {
  grid_.add(sample);
}

void EyewearTracker::forget(std::uint16_t sensor) {
  grid_.forget(sensor);
  const auto place = std::ranges::find(sensors_, sensor);
  if (place != sensors_.end()) calibrator_.forget(static_cast<std::size_t>(place - sensors_.begin()));
}

std::size_t EyewearTracker::normalise(double since_s) {
  read_features(calibrator_.in_force(), light_, features_);
  drift_.apply(since_s, features_);
  return static_cast<std::size_t>(std::ranges::count(features_.present, std::uint8_t{1}));
}

tracker::TickResult EyewearTracker::tick(DeviceTime frame, const sensor::TimeLines& lines,
                                         face::OutputFrame& out) {
  using Event = tracker::CalibrationEvent;
  tracker::TickResult result;
  grid_.tick(frame, lines, light_);
  const Calibrator::Change change = calibrator_.add(frame, light_);
  if (change != Calibrator::Change::none) {
    renewed_ = true;
    Event& event = result.calibration.emplace_back();
    event.kind = change == Calibrator::Change::calibrated ? Event::Kind::calibrated : Event::Kind::withdrawn;
    event.modality = modality();
    if (change == Calibrator::Change::calibrated && calibrator_.found())
      event.found.push_back({Step::neutral, calibrator_.found()->begin, calibrator_.found()->end});
  }
  out = {};
  out.time = frame;
  if (!calibrator_.in_force().complete) {
    out.provenance.fill(face::Provenance::neutral);
    result.sensors_present = sensors_.size();  // Not a loss: there was no calibration yet.
    return result;
  }
  if (std::exchange(renewed_, false)) {
    drift_.reset();
    model_.reset();
  }
  const double passed_s = last_frame_ ? to_seconds(frame - *last_frame_) : 0;
  const double since_s = passed_s > 0 ? std::min(passed_s, kLongestStepS) : 1 / kFrameRateHz;
  last_frame_ = frame;
  result.sensors_present = normalise(since_s);
  model_.step(features_, since_s, out);
  result.explained = model_.explained();
  return result;
}

tracker::Guidance EyewearTracker::guidance() const {
  return {.neutral = calibrator_.in_force().complete ? kRemounted : kFirstWorn, .gestures = false};
}

void EyewearTracker::guide(Step step, DeviceTime begin, DeviceTime end) {
  if (step == Step::neutral) calibrator_.guide(StretchKind::neutral, begin, end);
}

void EyewearTracker::guide_range(DeviceTime begin, DeviceTime end) {
  calibrator_.guide(StretchKind::range, begin, end);
}

void EyewearTracker::cancel_guidance() {
  calibrator_.cancel();
  renewed_ = true;
}

tracker::CalibrationState EyewearTracker::calibration_state() const {
  using Phase = tracker::CalibrationState::Phase;
  tracker::CalibrationState state;
  state.step = calibrator_.wants_neutral() ? Step::neutral : Step::none;
  state.hint = calibrator_.hint();
  if (calibrator_.guided()) {
    state.phase = Phase::guided;
  } else if (calibrator_.in_force().complete) {
    state.phase = Phase::done;
  } else if (state.hint.empty()) {
    state.hint = "Relax your face and hold still for two seconds: whatever it is then is taken for neutral";
  }
  return state;
}

std::string EyewearTracker::calibration() const {
  return calibrator_.in_force().complete ? write_normalisation(calibrator_.in_force()) : std::string();
}

std::vector<sensor::Score> EyewearTracker::scores() const {
  return calibrator_.in_force().scores;
}

Result<void> EyewearTracker::restore(std::string_view json) {
  MIEN_TRY_ASSIGN(const Normalisation normalisation, parse_normalisation(json, "calibration"));
  MIEN_TRY(calibrator_.restore(normalisation));
  renewed_ = true;
  return {};
}

}  // namespace mien::eyewear
