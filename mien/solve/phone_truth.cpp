#include "mien/solve/phone_truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/face/livelink_csv.h"
#include "mien/phone/inner_face.h"
#include "mien/phone/taps.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/rig_part.h"
#include "mien/solve/trace_features.h"
#include "mien/solve/whole_line.h"

namespace mien::solve {
namespace {

/// Marks where nothing was told for long: a frame without a face, in the middle of it.
void mark_gaps(face::Motion& motion) {
  std::vector<face::MotionFrame> frames;
  for (const face::MotionFrame& frame : motion.frames) {
    if (!frames.empty() && frames.back().has_face &&
        frame.time_s - frames.back().time_s > kLongestPhoneGapS) {
      face::MotionFrame lost = frames.back();
      lost.time_s = 0.5 * (lost.time_s + frame.time_s);
      lost.has_face = false;
      frames.push_back(lost);
    }
    frames.push_back(frame);
  }
  motion.frames = std::move(frames);
}

/// One face that was told, and when it arrived.
struct Told {
  DeviceTime time;
  HostTime arrival;
  std::uint32_t sequence = 0;
  phone::ToldFace face;
};

std::vector<Told> told_by(std::span<const take::StoredSample> samples, std::uint16_t sensor) {
  std::vector<Told> all;
  for (const take::StoredSample& stored : samples) {
    const sensor::Sample& sample = stored.sample;
    if (sample.sensor != sensor) continue;
    if (all.empty() || all.back().sequence != sample.sequence || all.back().time != sample.time)
      all.push_back({sample.time, stored.arrival, sample.sequence, {}});
    phone::add_sample(sample, all.back().face);
  }
  return all;
}

/// The longest stretch in which the phone's clock did not jump, in its time's order.
std::vector<Told> longest_stretch(std::vector<Told> all, double& left_out_s) {
  const auto length = [](const std::vector<Told>& stretch) {
    return stretch.empty() ? 0.0 : to_seconds(stretch.back().arrival - stretch.front().arrival);
  };
  std::vector<Told> longest, now;
  sensor::ClockModel clock;
  double sum_s = 0;
  const auto close = [&] {
    // What came out of order, or twice.
    std::ranges::sort(now, {}, &Told::time);
    const auto same = std::ranges::unique(now, {}, &Told::time);
    now.erase(same.begin(), same.end());
    sum_s += length(now);
    if (length(now) > length(longest)) std::swap(longest, now);
    now.clear();
  };
  for (Told& told : all) {
    if (clock.add(told.time, told.arrival)) close();
    now.push_back(std::move(told));
  }
  close();
  left_out_s = sum_s - length(longest);
  return longest;
}

/// When a device's packet of this time arrived.
struct Arrival {
  DeviceTime time;
  HostTime arrival;
};

/// By how much a device's clock is slow against the host's.
struct Rate {
  double ppm = 0, sigma_ppm = 0;
};

/// By the earliest arrival of each of equal pieces of the take, least squares. The residual variance says how
/// far these scatter, of themselves or because a network's least delay wanders, and so what the rate is
/// worth.
std::optional<Rate> rate_of(std::span<const Arrival> arrivals) {
  // Fewer: each piece's earliest is sharper, but less tells how they scatter
  // (docs/experiments/phone_truth.md).
  constexpr std::size_t kPieces = 8, kLeastPieces = 4;
  struct Point {
    double at_s = 0, late_s = 0;
  };
  if (arrivals.empty()) return std::nullopt;
  const Arrival& first = arrivals.front();
  const double length_s = std::max(1.0, to_seconds(arrivals.back().time - first.time));
  std::array<std::optional<Point>, kPieces> pieces;
  for (const Arrival& one : arrivals) {
    const Point point{to_seconds(one.time - first.time),
                      to_seconds((one.arrival - first.arrival) - (one.time - first.time))};
    const double place = std::clamp(kPieces * point.at_s / length_s, 0.0, kPieces - 1.0);
    std::optional<Point>& earliest = pieces[static_cast<std::size_t>(place)];
    if (!earliest || point.late_s < earliest->late_s) earliest = point;
  }
  std::vector<Point> points;
  for (const std::optional<Point>& earliest : pieces)
    if (earliest) points.push_back(*earliest);
  if (points.size() < kLeastPieces) return std::nullopt;
  const auto count = static_cast<double>(points.size());
  Point mean;
  for (const Point& point : points) mean.at_s += point.at_s / count, mean.late_s += point.late_s / count;
  double square = 0, product = 0, residual = 0;
  for (const Point& point : points) {
    square += std::pow(point.at_s - mean.at_s, 2);
    product += (point.at_s - mean.at_s) * (point.late_s - mean.late_s);
  }
  const double slope = product / square;
  for (const Point& point : points)
    residual += std::pow(point.late_s - mean.late_s - slope * (point.at_s - mean.at_s), 2);
  return Rate{1e6 * slope, 1e6 * std::sqrt(residual / (count - 2) / square)};
}

/// The phone's drift against the reference, in `prior`: by both rates, and by what crystals are like.
void set_drift(const std::optional<Rate>& phone, const std::optional<Rate>& reference,
               phone::AlignmentPrior& prior) {
  if (!phone || !reference) return;
  // A crystal's rate wanders with its temperature.
  constexpr double kRateWandersPpm = 1;
  const double variance = std::pow(std::hypot(phone->sigma_ppm, reference->sigma_ppm, kRateWandersPpm), 2);
  const double crystals = std::pow(prior.drift_sigma_ppm, 2);
  const double share = crystals / (crystals + variance);
  prior.drift_ppm = share * (phone->ppm - reference->ppm);
  prior.drift_sigma_ppm = std::sqrt(share * variance);
}

/// Where the phone's first frame stands on the reference's clock, by the earliest arrivals of both.
std::optional<phone::AlignmentPrior> prior_of(const sensor::Rig& rig,
                                              std::span<const take::StoredSample> samples,
                                              std::span<const Told> told, DeviceTime begin) {
  const auto reference = rig.find(rig.reference);
  if (!reference || samples.empty()) return std::nullopt;
  const Duration span = samples.back().arrival - samples.front().arrival;
  WholeLine phone(span), sensors(span);
  std::vector<Arrival> of_phone, of_sensors;
  for (const Told& one : told) of_phone.push_back({one.time, one.arrival});
  for (const take::StoredSample& stored : samples)
    if (stored.sample.sensor == *reference) of_sensors.push_back({stored.sample.time, stored.arrival});
  for (const Arrival& one : of_phone) phone.add(one.time, one.arrival);
  for (const Arrival& one : of_sensors) sensors.add(one.time, one.arrival);
  if (!phone.clock().ready() || !sensors.clock().ready()) return std::nullopt;
  // A phone is 60 to 120 ms later than a board, its pictures' processing included.
  constexpr double kPhoneLag_s = 0.09;
  const auto on_line = [&](DeviceTime time) {
    return to_seconds(sensors.clock().to_device(phone.clock().to_host(time)) - begin);
  };
  const DeviceTime first = told.front().time, last = told.back().time;
  const double length_s = std::max(1.0, to_seconds(last - first));
  phone::AlignmentPrior prior;
  set_drift(rate_of(of_phone), rate_of(of_sensors), prior);
  // Over the whole of it, so that a wrong drift does not count.
  prior.offset_s = 0.5 * (on_line(first) + on_line(last) - length_s) - kPhoneLag_s;
  return prior;
}

/// When the last of the calibration's steps ended; the first frame where there is none.
DeviceTime calibrated_at(std::span<const take::Event> events, DeviceTime begin) {
  constexpr std::array<std::string_view, 4> kSteps = {"neutral", "nod", "shake", "range"};
  for (const take::Event& event : events)
    if (std::ranges::find(kSteps, event.kind) != kSteps.end()) begin = std::max(begin, event.end);
  return begin;
}

/// What was told while the face was neutral; none where nothing was.
std::optional<face::BlendshapeWeights> rest_of(std::span<const take::Event> events,
                                               std::span<const take::TruthFrame> frames) {
  // The face has come to rest by then.
  constexpr double kSettled_s = 0.5;
  std::array<std::vector<float>, face::kShapeCount> told;
  for (const take::Event& event : events) {
    if (event.kind != "neutral") continue;
    for (const take::TruthFrame& frame : frames)
      if (frame.has_face && frame.time >= event.begin + from_seconds(kSettled_s) && frame.time < event.end)
        for (std::size_t k = 0; k < face::kShapeCount; ++k) told[k].push_back(frame.weights[k]);
  }
  if (told[0].empty()) return std::nullopt;
  face::BlendshapeWeights rest;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const auto middle = told[k].begin() + static_cast<std::ptrdiff_t>(told[k].size() / 2);
    std::ranges::nth_element(told[k], middle);
    rest[k] = *middle;
  }
  return rest;
}

Result<void> align_from_a_guess(std::span<const model::FeatureFrame> features, const PhoneTrack& track,
                                PhoneTruth& truth) {
  const auto begins_with = [&](const std::optional<phone::AlignmentPrior>& prior, FirstGuess guess) {
    if (!prior) return false;
    auto aligned = phone::align(features, track.motion, prior);
    if (!aligned) return false;
    truth.alignment = *std::move(aligned);
    truth.guess = guess;
    return true;
  };
  if (!track.prior) {
    if (track.sound && begins_with(track.sound->prior(), FirstGuess::sound)) return {};
    if (begins_with(phone::prior_by_taps(features, track.motion), FirstGuess::taps)) return {};
  }
  MIEN_TRY_ASSIGN(truth.alignment, phone::align(features, track.motion, track.prior));
  truth.guess = track.prior ? FirstGuess::arrivals : FirstGuess::none;
  return {};
}

}  // namespace

Result<PhoneTrack> phone_track(const sensor::Rig& rig, std::span<const take::StoredSample> samples,
                               DeviceTime begin) {
  const std::vector<std::uint16_t> truths = sensor::truths_of(rig);
  if (truths.empty())
    return fail(ErrorCode::not_found, "no phone was recorded as a truth", "rig " + rig.name,
                "record one beside the sensors (mien live --phone truth), or name its file");
  PhoneTrack track;
  for (const std::uint16_t sensor : truths) {
    const std::vector<Told> told = longest_stretch(told_by(samples, sensor), track.left_out_s);
    if (told.size() < 2) continue;
    track.motion.name = rig.sensors[sensor].name;
    track.begin = told.front().time;
    for (const Told& one : told) {
      face::MotionFrame frame;
      frame.time_s = to_seconds(one.time - told.front().time);
      const phone::InnerFace inner = phone::inner_face(one.face);
      std::copy_n(inner.weights.begin(), face::kShapeCount, frame.weights.values.begin());
      frame.tongue_out = inner.weights[face::kShapeCount];
      track.motion.frames.push_back(frame);
    }
    track.prior = prior_of(rig, samples, told, begin);
    mark_gaps(track.motion);
    return track;
  }
  return fail(ErrorCode::not_found, "the phone told nothing in this take", "rig " + rig.name,
              "look at the page's row of the phone while recording");
}

Result<PhoneTrack> phone_track(const std::filesystem::path& csv, std::vector<std::string>* warnings) {
  PhoneTrack track;
  MIEN_TRY_ASSIGN(face::LiveLinkMotion loaded, face::load_livelink(csv));
  track.motion = std::move(loaded.motion);
  track.start_s = loaded.start_s;
  if (warnings != nullptr) *warnings = std::move(loaded.warnings);
  mark_gaps(track.motion);
  return track;
}

Result<PhoneTruth> phone_truth(std::span<const take::Event> events,
                               std::span<const model::FeatureFrame> features, const PhoneTrack& track) {
  PhoneTruth truth;
  MIEN_TRY(align_from_a_guess(features, track, truth));
  if (track.sound) {
    const phone::TimeAlignment& at = truth.alignment;
    truth.after_sound_s = at.middle_s - track.sound->at.to_first_s(at.to_phone_s(at.middle_s));
  }
  const face::MotionCurve curve(track.motion);
  const DeviceTime begin = features.front().time, calibrated = calibrated_at(events, begin);
  for (const model::FeatureFrame& feature : features) {
    const double phone_s = truth.alignment.to_phone_s(to_seconds(feature.time - begin));
    const face::MotionFrame told = curve.at(phone_s);
    take::TruthFrame& frame = truth.frames.emplace_back();
    frame.time = feature.time;
    frame.weights = told.weights;
    frame.tongue_out = told.tongue_out;
    frame.has_face = told.has_face && phone_s >= 0 && phone_s <= curve.duration_s();
    frame.evaluated = frame.has_face && feature.time >= calibrated;
  }
  truth.rest = rest_of(events, truth.frames);
  const face::BlendshapeWeights off = truth.rest.value_or(face::BlendshapeWeights{});
  for (take::TruthFrame& frame : truth.frames)
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      frame.weights[k] = std::clamp(frame.weights[k] - off[k], 0.0F, 1.0F);
  return truth;
}

Result<LearntFromPhone> learn_from_phone(const take::Take& take,
                                         std::span<const model::FeatureFrame> features,
                                         const PhoneTrack& track, const face::Face& face,
                                         model::ModelFile& file, const Progress& progress) {
  MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
  MIEN_TRY_ASSIGN(const PhoneTruth truth, phone_truth(events, features, track));
  std::vector<tracker::TaughtFrame> taught;
  for (const take::TruthFrame& frame : truth.frames) taught.push_back({frame.evaluated, frame.weights});
  LearntFromPhone lesson{.alignment = truth.alignment, .learnt = {}};
  MIEN_TRY_ASSIGN(lesson.learnt, tracker::learn_correction(features, taught, traced_sensor_names(take.rig()),
                                                           face, file, progress));
  return lesson;
}

}  // namespace mien::solve
