#include "lab/headset/headset_hours.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>

#include "lab/headset/seen_film.h"
#include "mien/face/motion.h"
#include "mien/headset/headset_tracker.h"
#include "mien/measure/weight_errors.h"
#include "mien/performer/long_motion.h"
#include "mien/sensor/clock_model.h"
#include "mien/synthetic/headset/headset_dataset.h"
#include "mien/virtual/headset/headset_wearer.h"
#include "mien/virtual/performers.h"

namespace mien::lab {
namespace {

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
