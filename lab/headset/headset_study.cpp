#include "lab/headset/headset_study.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <iterator>
#include <numbers>
#include <span>
#include <utility>

#include "lab/headset/seen_film.h"
#include "mien/core/quantile.h"
#include "mien/face/motion.h"
#include "mien/face/shape_region.h"
#include "mien/headset/answer.h"
#include "mien/headset/headset_tracker.h"
#include "mien/measure/eyes_and_lips.h"
#include "mien/measure/metrics.h"
#include "mien/measure/weight_errors.h"
#include "mien/performer/long_motion.h"
#include "mien/sensor/clock_model.h"
#include "mien/solve/region_tally.h"
#include "mien/synthetic/headset/headset_dataset.h"
#include "mien/virtual/headset/headset_wearer.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

using face::kShapeCount;

/// Frames at rest: a second of the neutral.
constexpr int kRest = 60;
/// How far a headset is put on off where it was fitted.
constexpr double kShift_m = 0.004, kTilt_rad = 4 * std::numbers::pi / 180;
constexpr double kLost = 0.1;
constexpr std::uint64_t kLongestBurst = 10;
/// 15 Hz of 60.
constexpr std::size_t kSlowEvery = 4;
/// An eye that is open less than this is closed, and one that is open more can be asked where it looks.
constexpr float kClosed = 0.25F, kOpen = 0.4F;
constexpr double kDegPerRad = 180 / std::numbers::pi;

/// Which cameras' pictures of which frames arrive.
using Arrives = std::function<bool(std::size_t frame, std::size_t camera)>;

/// One frame of motion beside its truth.
struct Answered {
  face::OutputFrame frame;
  synthetic::FilmTruth truth;
};

/// Plays a take to a tracker: `neutral` first, if told, of any take of this wearer, after it `targets` that
/// are looked at, then the take's motion.
Result<std::vector<Answered>> play(const SeenFilm& take, const SeenFilm* neutral, const sensor::Rig& rig,
                                   const std::shared_ptr<const headset::HeadsetModel>& model,
                                   const Arrives& arrives, const SeenFilm* targets) {
  MIEN_TRY_ASSIGN(const auto tracker, headset::HeadsetTracker::create(rig, model));
  sensor::TimeLines lines(rig.sensors.size(), std::uint16_t{0});
  std::int64_t number = 0;
  face::OutputFrame out;
  const auto step = [&](const SeenFilm& of, std::size_t frame, bool all) {
    const DeviceTime now(frame_offset(number++));
    deliver(
        of.records[frame], now, rig, [&](std::size_t c) { return all || arrives(frame, c); }, lines,
        *tracker);
    tracker->tick(now, lines, out);
  };
  if (neutral != nullptr) {
    const DeviceTime begin(frame_offset(number));
    tracker->guide(tracker::Step::neutral, begin, begin + frame_offset(kRest - 2));
    for (std::size_t frame = 0; frame < kRest; ++frame) step(*neutral, frame, true);
  }
  if (targets != nullptr) {
    guide_gaze_targets(DeviceTime(frame_offset(number)), *tracker);
    for (std::size_t frame = 0; frame < targets->truth.size(); ++frame) step(*targets, frame, true);
  }
  std::vector<Answered> answered;
  for (std::size_t frame = kRest; frame < take.truth.size(); ++frame) {
    step(take, frame, false);
    answered.push_back({out, take.truth[frame]});
  }
  return answered;
}

/// How often something is, is said to be, and both.
struct Tally {
  double is = 0, told = 0, hits = 0;
  void add(bool truth, bool says) {
    is += truth ? 1 : 0;
    told += says ? 1 : 0;
    hits += truth && says ? 1 : 0;
  }
  void add(const Tally& other) {
    is += other.is;
    told += other.told;
    hits += other.hits;
  }
  /// None where it neither is nor is said to be.
  [[nodiscard]] std::optional<double> f1() const {
    return is + told > 0 ? std::optional(2 * hits / (is + told)) : std::nullopt;
  }
};

/// What one wearer adds to a score.
struct WearerPart {
  double squares = 0, mean_squares = 0, count = 0;
  std::array<double, 3> region_squares{}, region_count{};
  double pve_mm = 0, jitter = 0;
  std::vector<face::BlendshapeWeights> truth, estimate;
  Tally shut, lips;
  std::vector<double> gaze_deg;
  std::array<solve::Reliability, 3> reliability;
  std::array<solve::RocArea, 3> roc;
};

/// Left eye's, right eye's, mouth's; none.
std::optional<std::size_t> part_of_face(std::size_t k) {
  const std::string_view name = face::kShapeNames[k];
  switch (face::kShapeRegions[k]) {
    case face::ShapeRegion::brows:
    case face::ShapeRegion::eyes:
      if (name.ends_with("_L")) return 0;
      if (name.ends_with("_R")) return 1;
      return {};
    case face::ShapeRegion::mouth:
    case face::ShapeRegion::jaw:
      return 2;
    case face::ShapeRegion::cheeks:
      break;
  }
  return {};
}

/// How sure the tracker is of each region and of the eyes' directions, and whether it is right.
void judge(const Answered& one, const face::BlendshapeWeights& truth, WearerPart& part) {
  const auto within = solve::regions_within(one.frame.weights, truth);
  for (std::size_t r = 0; r < within.size(); ++r) {
    const std::size_t half = headset::half_of_face(r);
    const bool right = one.truth.visible[half] > 0 && within[r];
    part.reliability[half].add(one.frame.region_confidence[r], right);
    part.roc[half].add(one.frame.region_confidence[r], right);
  }
  double error = 0, count = 0;
  for (std::size_t e = 0; e < 2; ++e) {
    if (one.truth.openness[e] < kClosed) continue;
    error += std::abs(double{one.frame.eyes_rad[e].x()} - double{one.truth.gaze_rad[2 * e]}) +
             std::abs(double{one.frame.eyes_rad[e].y()} - double{one.truth.gaze_rad[2 * e + 1]});
    count += 2;
  }
  const bool right =
      one.truth.visible[0] > 0 && count > 0 && error <= count * double{headset::kRightGaze_rad};
  part.reliability[2].add(one.frame.eyes_confidence, right);
  part.roc[2].add(one.frame.eyes_confidence, right);
}

WearerPart part_of(const std::vector<Answered>& answered, const measure::Meter& meter,
                   const std::optional<measure::EyesAndLipsMeter>& gaps,
                   const std::vector<float>& mean_answer) {
  WearerPart part;
  for (const Answered& one : answered) {
    face::BlendshapeWeights truth;
    for (std::size_t k = 0; k < kShapeCount; ++k) {
      truth[k] = one.truth.weights[k];
      const double error = double{one.frame.weights[k]} - double{truth[k]};
      const double of_mean = 0.5 * (double{mean_answer[k]} + 1) - double{truth[k]};
      part.squares += error * error;
      part.mean_squares += of_mean * of_mean;
      ++part.count;
      if (const auto region = part_of_face(k)) {
        part.region_squares[*region] += error * error;
        ++part.region_count[*region];
      }
    }
    part.truth.push_back(truth);
    part.estimate.push_back(one.frame.weights);
    for (std::size_t e = 0; e < 2; ++e) {
      if (one.truth.openness[e] >= kOpen)
        part.gaze_deg.push_back(
            kDegPerRad * std::hypot(double{one.frame.eyes_rad[e].x() - one.truth.gaze_rad[2 * e]},
                                    double{one.frame.eyes_rad[e].y() - one.truth.gaze_rad[2 * e + 1]}));
      if (gaps)
        part.shut.add(one.truth.openness[e] < kClosed, gaps->openness(one.frame.weights)[e] < kClosed);
    }
    if (gaps)
      part.lips.add(gaps->lip_gap_mm(truth) < measure::EyesAndLipsMeter::kClosedLips_mm,
                    gaps->lip_gap_mm(one.frame.weights) < measure::EyesAndLipsMeter::kClosedLips_mm);
    judge(one, truth, part);
  }
  const measure::Stretch stretch{.truth = part.truth, .estimate = part.estimate};
  const measure::Metrics metrics = meter.measure(std::span(&stretch, 1));
  part.pve_mm = metrics.pve_mm.mean;
  part.jitter = metrics.jitter_ratio.value_or(0);
  return part;
}

HeadsetScore score_of(HeadsetCondition condition, const std::vector<WearerPart>& parts) {
  HeadsetScore score{.condition = condition};
  double squares = 0, mean_squares = 0, count = 0;
  Tally shut, lips;
  std::array<double, 3> region{}, region_count{};
  std::vector<measure::Stretch> stretches;
  std::vector<double> gaze_deg;
  for (const WearerPart& part : parts) {
    squares += part.squares;
    mean_squares += part.mean_squares;
    count += part.count;
    shut.add(part.shut);
    lips.add(part.lips);
    for (std::size_t r = 0; r < region.size(); ++r) {
      region[r] += part.region_squares[r];
      region_count[r] += part.region_count[r];
      score.reliability[r].add(part.reliability[r]);
      score.roc[r].add(part.roc[r]);
    }
    score.pve_mm += part.pve_mm / static_cast<double>(parts.size());
    score.jitter_ratio += part.jitter / static_cast<double>(parts.size());
    stretches.push_back({.truth = part.truth, .estimate = part.estimate});
    gaze_deg.insert(gaze_deg.end(), part.gaze_deg.begin(), part.gaze_deg.end());
  }
  score.mse = squares / count;
  score.mean_pose_mse = mean_squares / count;
  score.left_eye_mse = region[0] / region_count[0];
  score.right_eye_mse = region[1] / region_count[1];
  score.mouth_mse = region[2] / region_count[2];
  score.blink_f1 = measure::blink_f1(stretches);
  score.wink_f1 = measure::wink_f1(stretches);
  score.closed_f1 = shut.f1();
  score.lips_f1 = lips.f1();
  std::ranges::sort(gaze_deg);
  if (!gaze_deg.empty()) {
    score.gaze_median_deg = quantile_of_sorted(gaze_deg, 0.5);
    score.gaze_p90_deg = quantile_of_sorted(gaze_deg, 0.9);
  }
  return score;
}

/// 4 mm and 4 degrees in any direction.
virt::HeadsetSeat another_seat(Random random) {
  const auto direction = [&] {
    Vec3 v;
    do v = Vec3(random.normal(), random.normal(), random.normal());
    while (v.norm() < 0.1);
    return Vec3(v.normalized());
  };
  return {.shift_m = kShift_m * direction(), .tilt_rad = kTilt_rad * direction()};
}

/// Frames of the neutral, and of the rest that each piece begins with.
constexpr int kNeutralFrames = 3 * static_cast<int>(kFrameRateHz),
              kRestFrames = 5 * static_cast<int>(kFrameRateHz) / 2;
/// A wearer who is asked to rest does so a little later.
constexpr Duration kAsked = std::chrono::milliseconds(250);

/// What is filmed of the pieces, one after the other; `filmed` frames of each.
face::Motion filmed_motion(std::size_t pieces, int filmed, const Random& random) {
  face::Motion motion;
  for (std::size_t piece = 0; piece < pieces; ++piece) {
    const double begin_s = static_cast<double>(piece) * filmed / kFrameRateHz;
    for (int n = 0; n < kRestFrames; ++n) motion.frames.emplace_back().time_s = begin_s + n / kFrameRateHz;
    const double moved_s = (filmed - kRestFrames) / kFrameRateHz;
    for (face::MotionFrame& frame : synthetic::headset_motion(moved_s, random.fork("piece", piece)).frames) {
      if (frame.time_s >= moved_s) break;
      frame.time_s += begin_s + kRestFrames / kFrameRateHz;
      motion.frames.push_back(frame);
    }
  }
  return motion;
}

/// Plays a film to a tracker after a neutral; errors of each piece.
Result<std::vector<measure::WeightErrors>> play_hours(
    const SeenFilm& film, int filmed, bool recentres, const sensor::Rig& rig,
    const std::shared_ptr<const headset::HeadsetModel>& model) {
  MIEN_TRY_ASSIGN(const auto tracker, headset::HeadsetTracker::create(rig, model));
  sensor::TimeLines lines(rig.sensors.size(), std::uint16_t{0});
  face::OutputFrame out;
  std::vector<measure::WeightErrors> errors;
  const auto now_of = [&](std::size_t frame) {
    return DeviceTime(from_seconds(double{film.truth[frame].time_s}));
  };
  tracker->guide(tracker::Step::neutral, now_of(0), now_of(kNeutralFrames - 1));
  for (std::size_t n = 0; n < film.truth.size(); ++n) {
    const DeviceTime now = now_of(n);
    const int in_motion = static_cast<int>(n) - kNeutralFrames, in_piece = in_motion % filmed;
    if (in_motion >= 0 && in_piece == 0) {
      errors.emplace_back();
      if (recentres) tracker->rest(now + kAsked, now + kAsked + tracker->wants_rest());
    }
    deliver(film.records[n], now, rig, {}, lines, *tracker);
    const tracker::TickResult result = tracker->tick(now, lines, out);
    if ((in_motion == 0 && tracker->calibration().empty()) ||
        (result.rested && result.rested->corrected.size() != rig.sensors.size()))
      return fail(ErrorCode::internal, "a face at rest was not taken for one", "hours of a headset");
    if (in_motion < 0 || in_piece < kRestFrames) continue;
    face::BlendshapeWeights truth;
    std::ranges::copy(film.truth[n].weights, truth.values.begin());
    errors.back().add(out.weights, truth);
  }
  return errors;
}

/// Errors of the model's mean answer.
std::vector<measure::WeightErrors> mean_pose_errors(const SeenFilm& film, int filmed,
                                                    const std::vector<float>& mean_answer) {
  face::BlendshapeWeights mean, truth;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) mean[k] = 0.5F * (mean_answer[k] + 1);
  std::vector<measure::WeightErrors> errors;
  for (std::size_t n = kNeutralFrames; n < film.truth.size(); ++n) {
    const int in_piece = (static_cast<int>(n) - kNeutralFrames) % filmed;
    if (in_piece == 0) errors.emplace_back();
    if (in_piece < kRestFrames) continue;
    std::ranges::copy(film.truth[n].weights, truth.values.begin());
    errors.back().add(mean, truth);
  }
  return errors;
}

/// One wearer's errors, by piece.
struct WearerErrors {
  std::vector<measure::WeightErrors> slips, recentred, still, mean_pose;
};

std::vector<HeadsetHoursPiece> pieces_of(const WearerErrors& errors) {
  std::vector<HeadsetHoursPiece> out;
  for (std::size_t p = 0; p < errors.slips.size(); ++p) {
    HeadsetHoursPiece& piece = out.emplace_back();
    piece.begin_s = static_cast<double>(p) * performer::kPieceS;
    piece.mse = errors.slips[p].mse();
    piece.still_mse = errors.still[p].mse();
    piece.recentred_mse = errors.recentred[p].mse();
    piece.mean_pose_mse = errors.mean_pose[p].mse();
    const HeadsetHoursPiece& first = out.front();
    piece.ratio = piece.mse / piece.still_mse / (first.mse / first.still_mse);
    piece.recentred_ratio = piece.recentred_mse / piece.still_mse / (first.recentred_mse / first.still_mse);
    const auto bias = [&](std::size_t of, std::size_t k) {
      return std::abs(errors.slips[of].bias(k) - errors.still[of].bias(k));
    };
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      const double grown = bias(p, k) - bias(0, k);
      if (k > 0 && grown <= piece.worst_bias) continue;
      piece.worst_shape = k;
      piece.worst_bias = grown;
    }
  }
  return out;
}

}  // namespace

std::string_view condition_name(HeadsetCondition condition) {
  constexpr std::array<std::string_view, kHeadsetConditions> kNames = {
      "as worn",   "no neutral",          "put on anew",        "slipped", "15 Hz",
      "10 % lost", "a mouth camera lost", "an eye camera lost", "hidden",  "after five points"};
  return kNames[static_cast<std::size_t>(condition)];
}

Result<std::vector<HeadsetScore>> study_headset(const HeadsetStudyRequest& request, const sensor::Rig& rig,
                                                const std::shared_ptr<const headset::HeadsetModel>& model,
                                                const std::vector<float>& mean_answer,
                                                const Progress& progress) {
  if (request.wearers < 1 || !(request.seconds >= 1))
    return fail(ErrorCode::out_of_range, "a study needs a wearer, and a second");
  MIEN_TRY_ASSIGN(const virt::HeadsetFaults faults, virt::parse_headset_faults(rig.faults_toml, rig.name));
  MIEN_TRY(virt::check_network_views(rig));
  const auto side = static_cast<int>(model->network().architecture().side);
  const auto wearers = static_cast<std::size_t>(request.wearers);
  std::vector<std::array<WearerPart, kHeadsetConditions>> parts(wearers);
  const auto look_through = [&](std::size_t w) -> Result<void> {
    const Random root = Random(request.seed).fork("study wearer", w);
    MIEN_TRY_ASSIGN(const virt::HeadsetWearer wearer,
                    request.face ? virt::seat_headset(*request.face, rig, faults, root.fork("wearer"))
                                 : virt::draw_headset_wearer(rig, faults, root.fork("wearer")));
    const face::Motion motion =
        request.motion ? *request.motion : synthetic::headset_motion(request.seconds, root.fork("motion"));
    synthetic::HeadsetTakeRequest take{.frames = static_cast<int>(request.seconds * kFrameRateHz),
                                       .neutral_frames = kRest,
                                       .rate_hz = kFrameRateHz,
                                       .side = side};
    const auto film = [&](std::string_view name) {
      return look_at(film_wearer(wearer, faults, motion, take, root.fork(name)), rig, *model);
    };
    MIEN_TRY_ASSIGN(const SeenFilm usual, film("as worn"));
    take.seat = another_seat(root.fork("seat"));
    MIEN_TRY_ASSIGN(const SeenFilm anew, film("put on anew"));
    take.seat.reset();
    const auto failures = synthetic::test_failures();
    take.failure = failures[w % failures.size()];
    take.fails_from = kRest + take.frames / 3;
    MIEN_TRY_ASSIGN(const SeenFilm covered, film("hidden"));

    // In the seat of the take as worn.
    MIEN_TRY_ASSIGN(const SeenFilm targets,
                    look_at(synthetic::film_wearer(wearer, faults, gaze_targets_motion(root.fork("gaze")),
                                                   {.frames = static_cast<int>(kTaughtGaze_s * kFrameRateHz),
                                                    .neutral_frames = 0,
                                                    .rate_hz = kFrameRateHz,
                                                    .side = side},
                                                   root.fork("as worn")),
                            rig, *model));

    const measure::Meter meter(wearer.face);
    std::optional<measure::EyesAndLipsMeter> gaps;
    if (wearer.face.has_landmarks) gaps.emplace(wearer.face);
    std::vector<std::vector<bool>> lost(rig.sensors.size());
    Random random = root.fork("lost");
    for (auto& of : lost) {
      of.assign(usual.truth.size(), false);
      for (std::size_t i = 0; i < of.size(); ++i)
        if (random.chance(kLost / (0.5 * static_cast<double>(kLongestBurst + 1))))
          for (std::uint64_t n = 1 + random.below(kLongestBurst); n > 0 && i < of.size(); --n, ++i)
            of[i] = true;
    }
    const auto camera_named = [&](std::string_view site) {
      for (std::size_t c = 0; c < rig.sensors.size(); ++c)
        if (rig.sensors[c].site == site && rig.sensors[c].side == 'L') return c;
      return rig.sensors.size();
    };
    const std::size_t mouth = camera_named("mouth"), eye = camera_named("eye");
    const Arrives all = [](std::size_t, std::size_t) { return true; };
    const auto add = [&](HeadsetCondition condition, const SeenFilm& of, const SeenFilm* neutral,
                         const Arrives& arrives, const SeenFilm* looked_at = nullptr) -> Result<void> {
      MIEN_TRY_ASSIGN(const std::vector<Answered> answered,
                      play(of, neutral, rig, model, arrives, looked_at));
      parts[w][static_cast<std::size_t>(condition)] = part_of(answered, meter, gaps, mean_answer);
      return {};
    };
    using enum HeadsetCondition;
    MIEN_TRY(add(as_worn, usual, &usual, all));
    MIEN_TRY(add(no_neutral, usual, nullptr, all));
    MIEN_TRY(add(put_on_anew, anew, &anew, all));
    MIEN_TRY(add(slipped, anew, &usual, all));
    MIEN_TRY(add(slow, usual, &usual, [](std::size_t f, std::size_t) { return f % kSlowEvery == 0; }));
    MIEN_TRY(add(lossy, usual, &usual, [&](std::size_t f, std::size_t c) { return !lost[c][f]; }));
    MIEN_TRY(add(mouth_lost, usual, &usual, [&](std::size_t, std::size_t c) { return c != mouth; }));
    MIEN_TRY(add(eye_lost, usual, &usual, [&](std::size_t, std::size_t c) { return c != eye; }));
    MIEN_TRY(add(hidden, covered, &usual, all));
    MIEN_TRY(add(gaze_taught, usual, &usual, all, &targets));
    return {};
  };
  MIEN_TRY(virt::for_each_performer(wearers, request.threads, progress, look_through));
  std::vector<HeadsetScore> scores;
  for (std::size_t c = 0; c < kHeadsetConditions; ++c) {
    std::vector<WearerPart> of_condition;
    for (auto& of : parts) of_condition.push_back(std::move(of[c]));
    scores.push_back(score_of(static_cast<HeadsetCondition>(c), of_condition));
  }
  return scores;
}

Result<std::vector<std::vector<HeadsetHoursPiece>>> study_headset_hours(
    const HeadsetHoursRequest& request, const sensor::Rig& rig,
    const std::shared_ptr<const headset::HeadsetModel>& model, const std::vector<float>& mean_answer,
    const Progress& progress) {
  if (request.wearers < 1 || !(request.minutes >= 10 && request.minutes <= 600) ||
      !(request.seconds >= 1 && request.seconds <= 60))
    return fail(
        ErrorCode::out_of_range,
        "a study of hours takes a wearer or more, 10 to 600 minutes, and 1 to 60 seconds of motion in "
        "each ten of them");
  const auto pieces = static_cast<std::size_t>(60 * request.minutes / performer::kPieceS);
  MIEN_TRY_ASSIGN(const virt::HeadsetFaults faults, virt::parse_headset_faults(rig.faults_toml, rig.name));
  MIEN_TRY(virt::check_network_views(rig));
  virt::HeadsetFaults still = faults;
  still.slip_mm_per_sqrt_min = still.slip_deg_per_sqrt_min = 0;
  const int filmed = kRestFrames + static_cast<int>(request.seconds * kFrameRateHz);
  const synthetic::HeadsetTakeRequest take{.frames = static_cast<int>(pieces) * filmed,
                                           .neutral_frames = kNeutralFrames,
                                           .rate_hz = kFrameRateHz,
                                           .seat = {},
                                           .side = static_cast<int>(model->network().architecture().side),
                                           .filmed_at_once = filmed,
                                           .unfilmed_s = performer::kPieceS - filmed / kFrameRateHz};
  std::vector<WearerErrors> errors(static_cast<std::size_t>(request.wearers));
  // A film each of the headset that slips and of the one that does not.
  const auto wear = [&](std::size_t job) -> Result<void> {
    const std::size_t w = job / 2;
    const bool slips = job % 2 == 0;
    const Random root = Random(request.seed).fork("hours wearer", w);
    MIEN_TRY_ASSIGN(const virt::HeadsetWearer wearer,
                    virt::draw_headset_wearer(rig, faults, root.fork("wearer")));
    const face::Motion motion = filmed_motion(pieces, filmed, root.fork("motion"));
    MIEN_TRY_ASSIGN(const SeenFilm film,
                    look_at(film_wearer(wearer, slips ? faults : still, motion, take, root.fork("headset")),
                            rig, *model));
    if (!slips) {
      MIEN_TRY_ASSIGN(errors[w].still, play_hours(film, filmed, false, rig, model));
      return {};
    }
    MIEN_TRY_ASSIGN(errors[w].slips, play_hours(film, filmed, false, rig, model));
    MIEN_TRY_ASSIGN(errors[w].recentred, play_hours(film, filmed, true, rig, model));
    errors[w].mean_pose = mean_pose_errors(film, filmed, mean_answer);
    return {};
  };
  MIEN_TRY(virt::for_each_performer(2 * errors.size(), request.threads, progress, wear));
  std::vector<std::vector<HeadsetHoursPiece>> out;
  std::ranges::transform(errors, std::back_inserter(out), pieces_of);
  return out;
}

}  // namespace mien::lab
