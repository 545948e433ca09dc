#include "mien/imu/imu_tracker.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mien::imu {
namespace {

using tracker::Step;

/// A blink is over, and a breath's sway averages out; whoever relaxes for longer begins to speak.
constexpr Duration kRest = std::chrono::seconds(2);

}  // namespace

PipelineSettings ImuTracker::live_settings() {
  PipelineSettings settings;
  settings.calibrates_itself = true;
  return settings;
}

ImuTracker::ImuTracker(const sensor::Rig& rig, std::unique_ptr<tracker::FrameModel> model,
                       const PipelineSettings& settings)
    : face_(rig.face_sensors()),
      pipeline_(rig, settings),
      ready_(face_, settings.silence),
      model_(std::move(model)),
      learner_(rig.face_sensor_names()) {
  features_.sensors.resize(face_.size());
}

void ImuTracker::add(HostTime, const sensor::Sample& sample) {
  pipeline_.add(sample);
  ready_.add(sample);
}

void ImuTracker::forget(std::uint16_t sensor) {
  pipeline_.forget(sensor);
  ready_.forget(sensor);
}

tracker::TickResult ImuTracker::tick(DeviceTime frame, const sensor::TimeLines& lines,
                                     face::OutputFrame& out) {
  using Event = tracker::CalibrationEvent;
  tracker::TickResult result;
  const auto report = [&](Event::Kind kind) { result.calibration.push_back({kind, modality(), {}}); };

  const std::optional<Event> change = pipeline_.tick(frame, lines, features_);
  ready_.put(frame, features_);
  result.rested = pipeline_.rested();
  if (change) {
    report(change->kind);
    result.calibration.back().found = change->found;
  }
  // The nod puts a calibration in force; one that fails its checks reaches no frame.
  if (guided_until_ && change && pipeline_.calibration().complete && !passes_checks()) {
    revert_guidance();
    report(Event::Kind::withdrawn);
    features_.sensors.assign(face_.size(), model::SensorFeature{});
    features_.has_head = false;
  }
  if (guided_until_ && frame >= *guided_until_) {
    guided_until_.reset();
    if (!passes_checks()) {
      revert_guidance();
      report(Event::Kind::withdrawn);
    }
  }
  if (const model::ModelFile* file = personal())
    if (std::optional<tracker::WearerLearner::Learnt> learnt = learner_.add(features_, *file)) {
      use({.slopes = std::move(learnt->slopes), .correction = {}, .score = std::move(learnt->score)});
      report(Event::Kind::calibrated);
    }
  if (asked_until_ && frame >= *asked_until_) end_guidance();
  const auto present =
      static_cast<std::size_t>(std::ranges::count_if(features_.sensors, &model::SensorFeature::has_rotation));
  const bool begins = present == 0 && !pipeline_.calibration().complete;
  if (begins || model_ == nullptr) {
    out = face::neutral_frame(frame);
    result.sensors_present = begins ? face_.size() : present;  // No loss before there was a calibration.
    return result;
  }
  model_->step(features_, out);
  result.sensors_present = present;
  if (const tracker::Explained* explained = model_->explained()) result.explained = *explained;
  return result;
}

Duration ImuTracker::wants_rest() const {
  return pipeline_.follows_drift() ? kRest : Duration::zero();
}

void ImuTracker::rest(DeviceTime begin, DeviceTime end) {
  pipeline_.rest(begin, end);
}

tracker::Guidance ImuTracker::guidance() const {
  return {.learns_wearer = personal() != nullptr};
}

void ImuTracker::guide(Step step, DeviceTime begin, DeviceTime end) {
  if (step == Step::none) return;
  if (!guided_until_) {
    end_guidance();
    wearer_before_ = wearer_;
    wearer_.score.reset();
  }
  pipeline_.mark(step, begin, end);
  guided_until_ = guided_until_ ? std::max(*guided_until_, end) : end;
  asked_until_ = guided_until_;
  hint_ = {};
}

void ImuTracker::guide_range(DeviceTime, DeviceTime end) {
  if (asked_until_) asked_until_ = std::max(*asked_until_, end);
}

void ImuTracker::guide_expression(const tracker::PromptedExpression& asked) {
  if (!asked_until_ || personal() == nullptr) return;
  learner_.expect(asked);
  asked_until_ = std::max(*asked_until_, asked.end + tracker::kWearerLearnt + tracker::kWearerShown);
}

void ImuTracker::cancel_guidance() {
  if (asked_until_) revert_guidance();
}

void ImuTracker::end_guidance() {
  learner_.cancel();
  guided_until_.reset();
  asked_until_.reset();
}

void ImuTracker::revert_guidance() {
  end_guidance();
  pipeline_.cancel_marks();
  use(std::move(wearer_before_));
}

void ImuTracker::use(Wearer wearer) {
  const bool other_correction = wearer.correction != wearer_.correction;
  // A model that is corrected is asked for no skin: the skin first, then what corrects answers on it.
  if (other_correction) model_->use_correction(nullptr);
  if (personal() != nullptr && wearer.slopes != wearer_.slopes) model_->use_wearer(wearer.slopes);
  if (other_correction && wearer.correction) model_->use_correction(&*wearer.correction);
  wearer_ = std::move(wearer);
}

bool ImuTracker::passes_checks() {
  const Calibration& made = pipeline_.calibration();
  const auto failed = [&](std::string_view name) {
    return std::ranges::any_of(made.scores,
                               [&](const sensor::Score& score) { return score.name == name && !score.pass; });
  };
  if (!made.complete) {
    hint_ = "the head sensor or the nod was not seen; check the sensor behind the ear and calibrate again";
  } else if (failed("nod")) {
    hint_ = "the nod was too small; calibrate again and nod by 15 degrees or more";
  } else if (failed("nod axis")) {
    hint_ = "the nod was mixed with other turns; calibrate again and nod straight down and up";
  } else if (failed("neutral face")) {
    hint_ = "the face moved while it should hold still; relax it and calibrate again";
  } else {
    return true;
  }
  return false;
}

tracker::CalibrationState ImuTracker::calibration_state() const {
  tracker::CalibrationState state;
  state.step = pipeline_.step();
  state.hint = pipeline_.hint().empty() ? hint_ : pipeline_.hint();
  if (guided_until_)
    state.phase = tracker::CalibrationState::Phase::guided;
  else if (pipeline_.calibration().complete)
    state.phase = tracker::CalibrationState::Phase::done;
  return state;
}

std::string ImuTracker::calibration() const {
  if (!pipeline_.calibration().complete) return {};
  Calibration now = pipeline_.calibration_now();
  now.wearer = wearer_.slopes;
  now.correction = wearer_.correction;
  return write_calibration(now);
}

std::vector<sensor::Score> ImuTracker::scores() const {
  std::vector<sensor::Score> scores = pipeline_.calibration().scores;
  if (wearer_.score) scores.push_back(*wearer_.score);
  return scores;
}

Result<void> ImuTracker::restore(std::string_view json) {
  MIEN_TRY_ASSIGN(const Calibration calibration, parse_calibration(json, "calibration"));
  MIEN_TRY(pipeline_.restore(calibration));
  end_guidance();
  if (model_ == nullptr) return {};
  // Of a model whose answers are corrected nobody can tell whether it takes a skin.
  use({.slopes = wearer_.slopes, .correction = {}, .score = {}});
  Wearer wearer{.slopes = calibration.wearer, .correction = calibration.correction, .score = {}};
  if (wearer.correction && !model_->check_correction(*wearer.correction)) {
    // The rest of the calibration is valid.
    wearer.correction.reset();
    wearer.score = sensor::Score{.name = "phone",
                                 .value = 0,
                                 .unit = "",
                                 .pass = false,
                                 .sentence = "a phone taught another model; let it teach this one"};
  }
  const model::ModelFile* file = personal();
  if (!wearer.slopes.empty() && (file == nullptr || file->skin->standard.size() != wearer.slopes.size())) {
    // The rest of the calibration is valid.
    wearer.slopes.clear();
    // Both of another model: whoever lets this one learn the skin does the phone after it.
    wearer.score =
        sensor::Score{.name = "wearer",
                      .value = 0,
                      .unit = "nats",
                      .pass = false,
                      .sentence = calibration.correction && !wearer.correction
                                      ? "your skin and a phone's lesson are of another model; let "
                                        "this one learn the skin, then the phone's"
                                      : "your skin was learnt for another model; let this one learn it"};
  }
  use(std::move(wearer));
  return {};
}

Result<void> ImuTracker::correct(const model::Correction& correction) {
  if (model_ == nullptr) return Tracker::correct(correction);
  MIEN_TRY(model_->check_correction(correction));
  if (!pipeline_.calibration().complete)
    return fail(ErrorCode::not_found, "nothing is calibrated yet", "session", "calibrate first");
  Wearer wearer = wearer_;
  wearer.correction = correction;
  use(std::move(wearer));
  return {};
}

std::optional<double> ImuTracker::heading_sigma_rad(std::uint16_t sensor) const {
  const auto place = std::ranges::find(face_, sensor);
  const Calibration& calibration = pipeline_.calibration();
  if (place == face_.end() || !calibration.complete ||
      !calibration.sensors[static_cast<std::size_t>(place - face_.begin())].valid)
    return std::nullopt;
  return pipeline_.status(sensor).heading_sigma_rad;
}

std::optional<tracker::SensorCertainty> ImuTracker::certainty(std::uint16_t sensor) const {
  if (!pipeline_.follows_drift()) return std::nullopt;
  const SensorStatus status = pipeline_.status(sensor);
  if (!status.present) return std::nullopt;
  return tracker::SensorCertainty{.sigma_rad = std::sqrt(std::max(0.0, status.drift_rad2.trace()) +
                                                         status.tilt_sigma_rad * status.tilt_sigma_rad),
                                  .left_out = status.left_out};
}

std::uint64_t ImuTracker::faults() const {
  return face_.empty() ? 0 : pipeline_.status(face_.front()).faults;
}

}  // namespace mien::imu
