#include "mien/headset/headset_tracker.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "mien/core/logistic.h"
#include "mien/tracker/shape_confidence.h"

namespace mien::headset {
namespace {

using face::Provenance;
using tracker::CalibrationEvent;
using tracker::Step;

/// Where a camera's time runs back farther than this it began anew.
constexpr Duration kBeganAnew = std::chrono::milliseconds(200);
/// Share of a hold's frames in which all cameras must have been there.
constexpr double kThere = 0.5;

// Confidence by the cameras that are there: above the merge's `sure` where a shape is seen, below its
// `unsure` where it is guessed from what else is seen.
constexpr float kSeen = 0.9F;
constexpr float kSeenByOne = 0.6F;
constexpr float kGuessed = 0.2F;

/// Wider than for IMUs: pictures tell each moment anew and tremble less, so little delay is worth more.
/// Chosen on wearers whom no page reports (docs/experiments/headset.md#jitter).
constexpr tracker::JitterSettings kJitter{.cutoff_hz = 1, .beta = 2, .low_pass_hz = 12};

/// Frames in which a face that holds still is shown to a network with a memory: longer than it remembers.
constexpr int kSettles = 60;

/// Lids open less than this hide where the eye looks; open by kOpen they hide nothing.
constexpr float kClosed = 0.15F, kOpen = 0.4F;

/// Less sure than this the network does not see the eyes. Little, since it is the eyes that it finds wrongly
/// whose direction is to be learnt.
constexpr float kLeastGazeConfidence = 0.2F;

constexpr std::size_t kLeftEye = 0, kRightEye = 1, kLeftMouth = 2, kRightMouth = 3;

using Confidence = std::array<float, face::kShapeCount>;

float of_eye(const std::array<bool, model::kViews>& present, std::size_t eye) {
  if (present[eye]) return kSeen;
  return present[1 - eye] ? kGuessed : 0.0F;
}

float of_mouth(const std::array<bool, model::kViews>& present) {
  if (present[kLeftMouth] && present[kRightMouth]) return kSeen;
  return present[kLeftMouth] || present[kRightMouth] ? kSeenByOne : 0.0F;
}

/// Brows and lids are their eye's camera's; what raises the cheek or wrinkles the nose is seen from above and
/// below; all else is the mouth's.
float confidence_of(std::size_t shape, const std::array<bool, model::kViews>& present) {
  const std::string_view name = face::kShapeNames[shape];
  const std::size_t eye = name.ends_with("_R") ? kRightEye : kLeftEye;
  switch (face::kShapeRegions[shape]) {
    case face::ShapeRegion::brows:
    case face::ShapeRegion::eyes:
      return of_eye(present, eye);
    case face::ShapeRegion::cheeks:
      if (name.starts_with("cheekPuff")) return of_mouth(present);
      return std::max(std::min(of_eye(present, eye), kSeenByOne), of_mouth(present));
    case face::ShapeRegion::mouth:
    case face::ShapeRegion::jaw:
      break;
  }
  return of_mouth(present);
}

}  // namespace

Result<std::unique_ptr<HeadsetTracker>> HeadsetTracker::create(const sensor::Rig& rig,
                                                               std::shared_ptr<const HeadsetModel> model) {
  MIEN_TRY_ASSIGN(std::vector<HeadsetCamera> cameras,
                  headset_cameras(rig, model->network().architecture().side));
  MIEN_TRY_ASSIGN(FeatureReducer reducer, FeatureReducer::create(rig, model));
  return std::unique_ptr<HeadsetTracker>(
      new HeadsetTracker(std::move(cameras), std::move(model), std::move(reducer)));
}

HeadsetTracker::HeadsetTracker(std::vector<HeadsetCamera> cameras, std::shared_ptr<const HeadsetModel> model,
                               FeatureReducer reducer)
    : model_(std::move(model)),
      workspace_(model_->network()),
      reducer_(std::move(reducer)),
      reduced_(feature_record_bytes(model_->network().architecture().features)),
      jitter_filter_(kJitter),
      maker_(model_->network().architecture().features) {
  const std::size_t count = model_->network().architecture().features;
  moment_.features.resize(model::kViews * count);
  condition_.resize(moment_condition(count));
  if (model_->memory() != nullptr) state_.emplace(*model_->memory());
  const Newest<Seen, 32> none(Seen{.features = std::vector<float>(count)});
  for (HeadsetCamera& camera : cameras)
    channels_.push_back({.camera = std::move(camera), .pictures = none, .frozen = {}});
}

const HeadsetTracker::Seen* HeadsetTracker::Channel::at(DeviceTime time) const {
  for (std::size_t back = 0; back < pictures.size(); ++back) {
    const Seen& seen = pictures[back];
    if (seen.time > time + kAhead) continue;
    return time - seen.time <= kPresent && !seen.frozen ? &seen : nullptr;
  }
  return nullptr;
}

void HeadsetTracker::add_with_payload(HostTime, const sensor::Sample& sample,
                                      std::span<const std::byte> payload) {
  const auto channel =
      std::ranges::find_if(channels_, [&](const Channel& c) { return c.camera.sensor == sample.sensor; });
  if (channel == channels_.end()) return;
  if (!is_feature_record(payload)) {
    const auto bytes = reducer_.reduce_picture(sample.sensor, payload, reduced_);
    if (!bytes) return;
    payload = std::span(reduced_).first(*bytes);
  }
  const auto record = parse_feature_record(payload);
  // Found for another place, or by another network.
  if (!record || record->sensor != sample.sensor ||
      record->count() != model_->network().architecture().features)
    return;
  const DeviceTime time = sample.time - channel->camera.half_exposure;
  if (!channel->pictures.empty()) {
    const Duration since = time - channel->pictures[0].time;
    if (since < -kBeganAnew) {
      channel->pictures.clear();
      channel->frozen.restart();
    } else if (since <= Duration::zero()) {
      return;  // Doubled, or out of order.
    }
  }
  Seen& seen = channel->pictures.push();
  seen.time = time;
  seen.frozen = channel->frozen.add(record->statistics.hash);
  for (std::size_t i = 0; i < seen.features.size(); ++i) seen.features[i] = record->feature(i);
}

void HeadsetTracker::forget(std::uint16_t sensor) {
  for (Channel& channel : channels_) {
    if (channel.camera.sensor != sensor) continue;
    channel.pictures.clear();
    channel.frozen.restart();
    // What a face at rest looks like is another camera's.
    in_force_.reset();
    before_.reset();
    last_eyes_rad_.reset();
    forget_moments();
    if (hold_) maker_.begin();  // So are the frames that were gathered.
    rest_.reset();
    gaze_learner_.restart();
  }
}

void HeadsetTracker::change_view(std::uint16_t sensor, const sensor::PictureView& view) {
  reducer_.change_view(sensor, view);
  forget(sensor);
}

void HeadsetTracker::forget_moments() {
  if (state_) state_->reset();
  confidence_gain_.reset();
  jitter_filter_.reset();
}

void HeadsetTracker::gather(DeviceTime frame, const sensor::TimeLines& lines) {
  const std::size_t count = model_->network().architecture().features;
  moment_.present = {};
  for (std::size_t place = 0; place < model::kViews; ++place)
    std::ranges::copy(model_->network().missing(place),
                      std::span(moment_.features).subspan(place * count, count).begin());
  if (!lines.ready()) return;
  for (const Channel& channel : channels_) {
    const HeadsetCamera& camera = channel.camera;
    if (!lines.has_samples(camera.sensor)) continue;
    const DeviceTime now = lines.from_line(camera.sensor, frame);
    const Seen* const seen = channel.at(now);
    if (seen == nullptr) continue;
    moment_.present[camera.place] = true;
    moment_.age_s[camera.place] = static_cast<float>(std::max(0.0, to_seconds(now - seen->time)));
    std::ranges::copy(seen->features,
                      std::span(moment_.features).subspan(camera.place * count, count).begin());
  }
}

void HeadsetTracker::ask(const MomentFeatures& moment, const RestFeatures& rest,
                         model::CausalNetwork::State* state) {
  read_moment(model_->network(), moment, rest, workspace_, condition_);
  ask_again(state);
}

void HeadsetTracker::ask_again(model::CausalNetwork::State* state) {
  outputs_.fill(0);
  if (state != nullptr) model_->memory()->step(condition_, *state, outputs_);
  add_moment_answer(condition_, outputs_);
}

tracker::TickResult HeadsetTracker::tick(DeviceTime frame, const sensor::TimeLines& lines,
                                         face::OutputFrame& out) {
  static const RestFeatures kUnknown;
  tracker::TickResult result;
  out = face::neutral_frame(frame);
  gather(frame, lines);
  result.sensors_present = static_cast<std::size_t>(std::ranges::count(moment_.present, true));
  end_rest(frame, result);
  Answer answer;
  if (result.sensors_present > 0) {
    // A hold is judged by what is seen without the neutral before it.
    ask(moment_, in_force_ && !hold_ ? in_force_->neutral.rest : kUnknown, state_ ? &*state_ : nullptr);
    judge();
    answer = decode_answer(std::span(outputs_).first<kAnswerOutputs>());
  } else {
    forget_moments();
  }
  lead(frame, answer, result);
  if (rest_ && frame >= rest_->begin && result.sensors_present > 0) maker_.add(moment_, answer);
  const bool corrects = in_force_ && !hold_;
  if (corrects) in_force_->neutral.correct(answer);
  lead_gaze(frame, answer, result);
  if (result.sensors_present == 0) return result;
  if (corrects && in_force_->gaze) in_force_->gaze->correct(answer);
  if (state_) {
    confidence_gain_.apply(judged_.regions, answer);
    jitter_filter_.apply(answer.weights);
  }
  write(answer, out);
  result.explained = out.confidence;  // Nobody measured more; the merge must know who sees what.
  return result;
}

void HeadsetTracker::write(const Answer& answer, face::OutputFrame& out) {
  const Present& present = moment_.present;
  out.weights = answer.weights;
  out.tongue_out = answer.tongue_out;
  out.region_confidence = judged_.regions;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    out.confidence[k] = confidence_of(k, present);
    // Where the eyes look is told by their directions, which the lids follow (shaping::Lids).
    out.provenance[k] =
        out.confidence[k] > kGuessed && !tracker::is_gaze(k) ? Provenance::measured : Provenance::predicted;
    if (model_->memory() != nullptr)
      out.confidence[k] = std::min(out.confidence[k] > kGuessed ? 1.0F : out.confidence[k],
                                   out.region_confidence[static_cast<std::size_t>(face::kShapeRegions[k])]);
  }
  std::array<float, 2> seen{};
  for (std::size_t e = 0; e < seen.size(); ++e)
    if (present[e])
      seen[e] = judged_.gaze * std::clamp((answer.openness[e] - kClosed) / (kOpen - kClosed), 0.0F, 1.0F);
  const bool sees = seen[0] > 0 || seen[1] > 0;
  if (sees) {
    last_eyes_rad_.emplace();
    for (std::size_t e = 0; e < seen.size(); ++e) {
      const std::size_t from = seen[e] > 0 ? e : 1 - e;
      (*last_eyes_rad_)[e] = {answer.gaze_rad[2 * from], answer.gaze_rad[2 * from + 1]};
    }
    // The better eye tells for both.
    out.eyes_confidence = std::max(seen[0], seen[1]);
  }
  if (!last_eyes_rad_) return;
  out.eyes_rad = *last_eyes_rad_;
  out.eyes_provenance = sees ? Provenance::measured : Provenance::held;
}

void HeadsetTracker::judge() {
  judged_ = {.regions = {}, .gaze = kSeen};
  if (model_->memory() == nullptr) return;
  const std::span<const float> logits = std::span(outputs_).subspan(kAnswerOutputs);
  for (std::size_t r = 0; r < judged_.regions.size(); ++r)
    judged_.regions[r] = model_->probability(r, logits[r]);
  judged_.gaze = model_->probability(kGazeJudgement, logits[kGazeJudgement]);
}

std::size_t HeadsetTracker::least_frames(const Hold& hold) {
  const double frames = kThere * kFrameRateHz * to_seconds(hold.end - hold.begin);
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(frames)));
}

NeutralFace HeadsetTracker::make_neutral(const NeutralFace* before, std::size_t least,
                                         std::optional<model::CausalNetwork::State>& state) {
  std::vector<std::string> names;
  for (const Channel& channel : channels_) names.push_back(channel.camera.name);
  NeutralFace made = maker_.make(std::move(names));
  made.network = model_->hash();
  const std::size_t count = model_->network().architecture().features;
  const auto view = [count](std::vector<float>& features, std::size_t place) {
    return std::span(features).subspan(place * count, count);
  };
  for (std::size_t place = 0; before != nullptr && place < model::kViews; ++place) {
    if (maker_.frames_with(place) >= least) continue;
    made.rest.present[place] = before->rest.present[place];
    std::ranges::copy(std::span(before->rest.features).subspan(place * count, count),
                      view(made.rest.features, place).begin());
  }
  // What it still answers of the face at rest itself, told that it is at rest.
  MomentFeatures at_rest{
      .features = made.rest.features, .present = made.rest.present, .age_s = maker_.mean_age_s()};
  for (std::size_t place = 0; place < model::kViews; ++place)
    if (!at_rest.present[place])
      std::ranges::copy(model_->network().missing(place), view(at_rest.features, place).begin());
  if (model_->memory() != nullptr) state.emplace(*model_->memory());
  ask(at_rest, made.rest, state ? &*state : nullptr);
  for (int frame = 1; state && frame < kSettles; ++frame) ask_again(&*state);
  made.correct_by(decode_answer(std::span(outputs_).first<kAnswerOutputs>()));
  judge_mirrored(made);
  return made;
}

void HeadsetTracker::judge_mirrored(NeutralFace& neutral) const {
  const std::size_t count = model_->network().architecture().features;
  if (model_->mirrored_eye().weight.size() != count) return;
  std::array<std::optional<float>, 2> log_odds;
  for (const std::size_t eye : {kLeftEye, kRightEye})
    if (neutral.rest.present[eye])
      log_odds[eye] =
          model_->mirrored_eye().logit(std::span(neutral.rest.features).subspan(eye * count, count));
  const bool both =
      log_odds[kLeftEye].value_or(0) > kSurelyMirrored && log_odds[kRightEye].value_or(0) > kSurelyMirrored;
  for (const Channel& channel : channels_) {
    const std::size_t place = channel.camera.place;
    if (place > kRightEye || !log_odds[place]) continue;
    const float mirrored = *log_odds[place];
    neutral.scores.push_back(
        {.name = "unmirrored " + channel.camera.name,
         .value = logistic(-double{mirrored}),
         .unit = "",
         .pass = mirrored <= kSurelyMirrored,
         .sentence =
             "how likely its view stands as the network wants it; where it does not, " +
             std::string(both ? "the two eye cameras are probably swapped: bind each to the other's device"
                              : "change the camera's mirror") +
             ", then calibrate again"});
  }
}

bool HeadsetTracker::is_complete(const Present& present) const {
  if (std::ranges::find(present, true) == present.end()) return false;
  for (std::size_t place = 0; place < present.size(); ++place)
    if ((*awaited_)[place] && !present[place]) return false;
  return true;
}

void HeadsetTracker::use_neutral(NeutralFace neutral) {
  std::optional<GazeMap> gaze;
  if (in_force_ && in_force_->gaze) gaze = in_force_->gaze->gains();
  in_force_ = {.neutral = std::move(neutral), .gaze = gaze};
}

void HeadsetTracker::lead(DeviceTime frame, const Answer& answer, tracker::TickResult& result) {
  if (hold_ && frame >= hold_->end) {
    CalibrationEvent& event = result.calibration.emplace_back();
    event.modality = modality();
    const Hold hold = *std::exchange(hold_, std::nullopt);
    if (maker_.frames() >= least_frames(hold)) {
      std::optional<model::CausalNetwork::State> settled;
      use_neutral(make_neutral(nullptr, 0, settled));
      event.kind = CalibrationEvent::Kind::calibrated;
    } else {
      failure_ = "a camera gave too few pictures during the hold; check the cameras and calibrate again";
      in_force_ = before_;
      gaze_learner_.clear();
      event.kind = CalibrationEvent::Kind::withdrawn;
    }
  }
  if (hold_ && frame >= hold_->begin) {
    // Cameras that give nothing when it begins are not waited for.
    if (!awaited_) awaited_ = moment_.present;
    if (is_complete(moment_.present)) maker_.add(moment_, answer);
  }
  if (guided_until_ && frame >= *guided_until_) guided_until_.reset();
}

void HeadsetTracker::end_rest(DeviceTime frame, tracker::TickResult& result) {
  if (!rest_ || frame < rest_->end) return;
  const std::size_t least = least_frames(*std::exchange(rest_, std::nullopt));
  tracker::RestOutcome& rested = result.rested.emplace();
  for (const Channel& channel : channels_)
    (maker_.frames_with(channel.camera.place) >= least ? rested.corrected : rested.absent)
        .push_back(channel.camera.sensor);
  if (rested.corrected.empty()) return;
  std::optional<model::CausalNetwork::State> settled;
  NeutralFace made = make_neutral(&in_force_->neutral, least, settled);
  if (!made.scores.front().pass) {
    rested.moved = std::exchange(rested.corrected, {});
    return;
  }
  use_neutral(std::move(made));
  state_ = std::move(settled);
}

void HeadsetTracker::lead_gaze(DeviceTime frame, const Answer& answer, tracker::TickResult& result) {
  if (gaze_learner_.is_over(frame)) {
    CalibrationEvent& event = result.calibration.emplace_back();
    event.modality = modality();
    if (in_force_) {
      GazeLearner::Learnt learnt = gaze_learner_.learn();
      if (learnt.map) in_force_->gaze = learnt.map;
      std::vector<sensor::Score>& scores = in_force_->neutral.scores;
      std::erase_if(scores, [](const sensor::Score& score) { return score.name.starts_with("gaze "); });
      std::ranges::move(learnt.scores, std::back_inserter(scores));
      event.kind = CalibrationEvent::Kind::calibrated;
    } else {
      failure_ = "nothing is known of the face at rest, which directions are read against; calibrate again";
      event.kind = CalibrationEvent::Kind::withdrawn;
    }
    gaze_learner_.clear();
  }
  if (!gaze_learner_.asks() || !in_force_ || hold_ || result.sensors_present == 0) return;
  GazeLearner::Found found;
  if (judged_.gaze >= kLeastGazeConfidence)
    for (std::size_t e = 0; e < found.size(); ++e)
      if (moment_.present[e] && answer.openness[e] >= kOpen)
        found[e] = Eigen::Vector2f(answer.gaze_rad[2 * e], answer.gaze_rad[2 * e + 1]);
  gaze_learner_.add(frame, found);
}

tracker::Guidance HeadsetTracker::guidance() const {
  const bool sees_eye =
      std::ranges::any_of(channels_, [](const Channel& c) { return c.camera.place <= kRightEye; });
  return {.neutral = kNeutral, .gestures = false, .learns_gaze = sees_eye};
}

void HeadsetTracker::guide_until(DeviceTime end) {
  if (!guided_until_) before_ = in_force_;
  guided_until_ = std::max(end, guided_until_.value_or(end));
}

void HeadsetTracker::guide(Step step, DeviceTime begin, DeviceTime end) {
  if (step != Step::neutral) return;
  guide_until(end);
  hold_ = Hold{begin, end};
  rest_.reset();
  awaited_.reset();
  maker_.begin();
  gaze_learner_.clear();
  failure_ = {};
}

void HeadsetTracker::guide_range(DeviceTime, DeviceTime end) {
  if (guided_until_) guided_until_ = std::max(end, *guided_until_);
}

void HeadsetTracker::guide_gaze(const face::GazeTarget& target, DeviceTime begin, DeviceTime end) {
  guide_until(end);
  gaze_learner_.ask(target, begin, end);
}

Duration HeadsetTracker::wants_rest() const {
  return in_force_ && !guided_until_ ? kRest : Duration::zero();
}

void HeadsetTracker::rest(DeviceTime begin, DeviceTime end) {
  rest_.reset();
  if (end <= begin || wants_rest() == Duration::zero()) return;
  rest_ = Hold{begin, end};
  maker_.begin();
}

void HeadsetTracker::cancel_guidance() {
  if (!guided_until_) return;
  guided_until_.reset();
  hold_.reset();
  gaze_learner_.clear();
  in_force_ = before_;
}

tracker::CalibrationState HeadsetTracker::calibration_state() const {
  using Phase = tracker::CalibrationState::Phase;
  tracker::CalibrationState state;
  state.hint = failure_;
  if (hold_) {
    state.phase = Phase::guided;
    state.step = Step::neutral;
  } else {
    state.phase = gaze_learner_.asks() ? Phase::guided : Phase::done;
  }
  return state;
}

std::string HeadsetTracker::calibration() const {
  return in_force_ ? write_wearer_calibration(*in_force_) : std::string();
}

std::vector<sensor::Score> HeadsetTracker::scores() const {
  return in_force_ ? in_force_->neutral.scores : std::vector<sensor::Score>();
}

Result<void> HeadsetTracker::restore(std::string_view json) {
  MIEN_TRY_ASSIGN(WearerCalibration calibration, parse_wearer_calibration(json, "calibration"));
  if (!std::ranges::equal(calibration.neutral.cameras, channels_, {}, {},
                          [](const Channel& channel) { return channel.camera.name; }))
    return fail(ErrorCode::mismatch, "the calibration is of another rig's cameras", "calibration",
                "calibrate anew");
  if (calibration.neutral.network != model_->hash())
    return fail(ErrorCode::mismatch, "the calibration was made with another model", "calibration",
                "calibrate anew");
  cancel_guidance();
  rest_.reset();
  in_force_ = std::move(calibration);
  failure_ = {};
  return {};
}

}  // namespace mien::headset
