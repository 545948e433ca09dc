#include "mien/synthetic/headset/headset_dataset.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mien/core/sha256.h"
#include "mien/core/toml.h"
#include "mien/performer/canvas.h"
#include "mien/performer/performer.h"
#include "mien/performer/script.h"
#include "mien/performer/style.h"
#include "mien/synthetic/recipe_table.h"
#include "mien/virtual/headset/headset_wearer.h"
#include "mien/virtual/performers.h"

namespace mien::synthetic {
namespace {

using face::kShapeCount;
using virt::HeadsetFailure;

/// Share of the time in which single shapes and few are held, so that each is seen alone.
constexpr double kPosesOfFilms = 0.4;
/// A pose is held so long, and another one reached in so long, seconds.
constexpr double kHeldLeast_s = 0.15, kHeldMost_s = 0.5, kReached_s = 0.12;

/// Both eyes look the same way, up to a little.
void look_anywhere(face::MotionFrame& pose, Random& random) {
  const double yaw = random.normal(0, 0.28), pitch = random.normal(0, 0.2);
  const auto look = [&](std::string_view more, std::string_view less, double rad) {
    const double weight = std::clamp(rad / face::kEyeTurnRadPerUnit, -0.9, 0.9);
    pose.weights[face::shape_index(more)] = static_cast<float>(std::max(0.0, weight));
    pose.weights[face::shape_index(less)] = static_cast<float>(std::max(0.0, -weight));
  };
  const double inwards = random.uniform(0, 0.06);
  look("eyeLookOut_L", "eyeLookIn_L", yaw - inwards);
  look("eyeLookIn_R", "eyeLookOut_R", yaw + inwards);
  look("eyeLookUp_L", "eyeLookDown_L", pitch);
  look("eyeLookUp_R", "eyeLookDown_R", pitch);
}

/// Few shapes at once, most of them on both sides; the eyes anywhere.
face::MotionFrame any_pose(Random& random) {
  face::MotionFrame pose;
  const std::uint64_t count = 1 + random.below(5);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::size_t k = random.below(kShapeCount);
    const auto weight = static_cast<float>(random.uniform(0.15, 1.0));
    pose.weights[k] = weight;
    if (random.chance(0.7)) pose.weights[performer::other_side(k)] = weight;
  }
  if (random.chance(0.1)) {
    pose.tongue_out = static_cast<float>(random.uniform(0.3, 1));
    pose.weights[face::shape("jawOpen")] = std::max(pose.weights[face::shape("jawOpen")], 0.3F);
  }
  // Lips that meet over an open jaw need the jaw.
  pose.weights[face::shape("mouthClose")] =
      std::min(pose.weights[face::shape("mouthClose")], pose.weights[face::shape("jawOpen")]);
  look_anywhere(pose, random);
  return pose;
}

/// The pose after `before`.
face::MotionFrame next_pose(const face::MotionFrame& before, const PoseShares& shares, Random& random) {
  if (shares == PoseShares{}) return any_pose(random);
  const double which = random.uniform();
  if (which < shares.eyes_alone) {
    face::MotionFrame pose = random.chance(0.5) ? before : face::MotionFrame();
    look_anywhere(pose, random);
    return pose;
  }
  face::MotionFrame pose = any_pose(random);
  const auto at_least = [&](std::size_t k, double least) {
    pose.weights[k] = std::max(pose.weights[k], static_cast<float>(random.uniform(least, 1)));
  };
  if (which < shares.eyes_alone + shares.winks) {
    const bool left = random.chance(0.5);
    at_least(left ? face::shape("eyeBlink_L") : face::shape("eyeBlink_R"), 0.7);
    pose.weights[left ? face::shape("eyeBlink_R") : face::shape("eyeBlink_L")] = 0;
    if (random.chance(0.5)) at_least(left ? face::shape("eyeSquint_L") : face::shape("eyeSquint_R"), 0.2);
    if (random.chance(0.5)) at_least(left ? face::shape("cheekSquint_L") : face::shape("cheekSquint_R"), 0.2);
  } else if (which < shares.eyes_alone + shares.winks + shares.closed_lips) {
    const auto gape = static_cast<float>(random.uniform(0.1, 0.6));
    pose.weights[face::shape("jawOpen")] = pose.weights[face::shape("mouthClose")] = gape;
    pose.tongue_out = 0;
  }
  return pose;
}

/// From 0 to 1 with minimum jerk.
face::MotionFrame between(const face::MotionFrame& a, const face::MotionFrame& b, double t) {
  const auto u = static_cast<float>(minimum_jerk(t));
  face::MotionFrame mixed = a;
  for (std::size_t k = 0; k < kShapeCount; ++k) mixed.weights[k] = std::lerp(a.weights[k], b.weights[k], u);
  mixed.tongue_out = std::lerp(a.tongue_out, b.tongue_out, u);
  return mixed;
}

virt::HeadsetPose pose_of(const face::MotionFrame& frame) {
  virt::HeadsetPose pose{.weights = frame.weights, .tongue_out = std::clamp(frame.tongue_out, 0.0F, 1.0F)};
  for (std::size_t k = 0; k < kShapeCount; ++k) pose.weights[k] = std::clamp(pose.weights[k], 0.0F, 1.0F);
  return pose;
}

FilmTruth truth_of(const virt::HeadsetPose& pose, const virt::HeadsetTruth& seen, bool neutral) {
  FilmTruth truth;
  for (std::size_t k = 0; k < kShapeCount; ++k) truth.weights[k] = pose.weights[k];
  truth.tongue_out = pose.tongue_out;
  truth.gaze_rad = {seen.gaze_rad[0].x(), seen.gaze_rad[0].y(), seen.gaze_rad[1].x(), seen.gaze_rad[1].y()};
  truth.openness = seen.openness;
  truth.pupil_mm = seen.pupil_mm;
  truth.visible = {seen.is_visible[0] ? 1.0F : 0.0F, seen.is_visible[1] ? 1.0F : 0.0F};
  truth.neutral = neutral ? 1 : 0;
  return truth;
}

/// When something comes before the face that was free at rest, and in half of the takes leaves it again. What
/// a wearer has, or put on badly, is there from the beginning.
void draw_times(Random& random, HeadsetTakeRequest& request) {
  if (request.failure == HeadsetFailure::moustache || request.failure == HeadsetFailure::poor_seat) return;
  constexpr double kEarliest = 0.1, kLatest = 0.6, kShortest = 0.15, kLongest = 0.5, kLeaves = 0.5;
  const auto frame = [&](double from, double to) {
    return static_cast<int>(random.uniform(from, to) * request.frames);
  };
  request.fails_from = request.neutral_frames + frame(kEarliest, kLatest);
  if (random.chance(kLeaves)) request.fails_to = request.fails_from + frame(kShortest, kLongest);
}

Result<std::vector<FilmFrame>> film_person(const HeadsetDataRecipe& recipe, const sensor::Rig& rig,
                                           const virt::HeadsetFaults& faults, const Random& root) {
  MIEN_TRY_ASSIGN(const virt::HeadsetWearer wearer,
                  virt::draw_headset_wearer(rig, faults, root.fork("wearer")));
  std::vector<FilmFrame> frames;
  const std::vector<HeadsetFailure> failures = training_failures();
  for (int d = 0; d < recipe.donnings; ++d) {
    const Random donning = root.fork("donning", static_cast<std::uint64_t>(d));
    Random chance = donning.fork("failure");
    HeadsetTakeRequest request{
        .frames = recipe.frames,
        .neutral_frames = recipe.neutral_frames,
        .rate_hz = recipe.rates_hz[static_cast<std::size_t>(d) % recipe.rates_hz.size()],
        .side = recipe.side};
    if (chance.chance(recipe.failing)) {
      request.failure = failures[chance.below(failures.size())];
      draw_times(chance, request);
    }
    std::vector<FilmFrame> part = film_wearer(
        wearer, faults, headset_motion(recipe.frames / request.rate_hz, donning.fork("motion"), recipe.poses),
        request, donning.fork("headset"));
    std::ranges::move(part, std::back_inserter(frames));
  }
  return frames;
}

}  // namespace

std::vector<HeadsetFailure> training_failures() {
  return {HeadsetFailure::hand,  HeadsetFailure::moustache, HeadsetFailure::poor_seat,
          HeadsetFailure::smear, HeadsetFailure::dark,      HeadsetFailure::covered};
}

std::vector<HeadsetFailure> test_failures() {
  return {HeadsetFailure::cup, HeadsetFailure::mask, HeadsetFailure::sun};
}

face::Motion headset_motion(double seconds, const Random& random, const PoseShares& poses) {
  const double poses_s = kPosesOfFilms * seconds;
  Random style = random.fork("style"), script = random.fork("script"), drawn = random.fork("poses");
  face::Motion motion = performer::perform(performer::random_script(std::max(0.1, seconds - poses_s), script),
                                           performer::draw_style(style), random.fork("motion"));
  face::MotionFrame from = motion.frames.back(), to = from;
  const double begin_s = from.time_s;
  double left_s = begin_s, reached_s = begin_s;
  for (double t = begin_s + 1 / kFrameRateHz; t < begin_s + poses_s; t += 1 / kFrameRateHz) {
    if (t >= left_s) {
      from = to;
      to = next_pose(from, poses, drawn);
      reached_s = t + kReached_s;
      left_s = reached_s + drawn.uniform(kHeldLeast_s, kHeldMost_s);
    }
    face::MotionFrame frame = between(from, to, std::clamp(1 - (reached_s - t) / kReached_s, 0.0, 1.0));
    frame.time_s = t;
    motion.frames.push_back(frame);
  }
  return motion;
}

std::vector<FilmFrame> film_wearer(const virt::HeadsetWearer& wearer, const virt::HeadsetFaults& faults,
                                   const face::Motion& motion, const HeadsetTakeRequest& request,
                                   const Random& random) {
  virt::HeadsetSimulator simulator(wearer, faults, random.fork("headset"), request.side, request.failure);
  if (request.seat)
    simulator.sit(*request.seat);
  else
    simulator.put_on();
  const face::MotionCurve curve(motion);
  const double rolling_s = 1e-3 * faults.rolling_ms;
  std::vector<FilmFrame> frames;
  for (int n = 0; n < request.neutral_frames + request.frames; ++n) {
    const bool neutral = n < request.neutral_frames;
    const int moved = std::max(0, n - request.neutral_frames);
    const double t = n / request.rate_hz + moved / request.filmed_at_once * request.unfilmed_s,
                 moved_s = moved / request.rate_hz;
    if (request.failure != HeadsetFailure::none)
      simulator.fail(n >= request.fails_from && n < request.fails_to);
    virt::HeadsetPose first, last;
    if (!neutral) {
      first = pose_of(curve.at(moved_s));
      last = pose_of(curve.at(moved_s + rolling_s));
    }
    FilmFrame& frame = frames.emplace_back();
    std::vector<std::span<std::uint8_t>> out;
    for (std::size_t c = 0; c < simulator.cameras(); ++c)
      frame.views.emplace_back(static_cast<std::size_t>(simulator.size(c).width) *
                               static_cast<std::size_t>(simulator.size(c).height));
    for (auto& view : frame.views) out.emplace_back(view);
    const virt::HeadsetTruth seen = simulator.shoot(t, first, last, out);
    frame.truth = truth_of(first, seen, neutral);
    frame.truth.time_s = static_cast<float>(t);
  }
  return frames;
}

Result<std::vector<headset::HeadsetCamera>> film_cameras(const sensor::Rig& rig, std::size_t side) {
  MIEN_TRY_ASSIGN(std::vector<headset::HeadsetCamera> cameras, headset::headset_cameras(rig, side));
  for (headset::HeadsetCamera& camera : cameras) {
    camera.view.left = camera.view.top = 0;
    camera.view.right = camera.view.bottom = 1;
  }
  return cameras;
}

Result<HeadsetDataRecipe> parse_headset_data_recipe(std::string_view text, const std::string& where) {
  MIEN_TRY_ASSIGN(const toml::table table, parse_toml(text, where + ", [data]"));
  HeadsetDataRecipe recipe;
  RecipeTable data(table, "data.", where);
  data.number("seed", recipe.seed, 0, std::numeric_limits<std::int64_t>::max());
  data.number("wearers", recipe.wearers, 1, 100'000);
  data.number("validation_wearers", recipe.validation_wearers, 1, 10'000);
  data.number("donnings", recipe.donnings, 1, 100);
  data.number("frames", recipe.frames, 1, 100'000);
  data.number("neutral_frames", recipe.neutral_frames, 0, 1000);
  data.number("side", recipe.side, 16, 256);
  data.number("failing", recipe.failing, 0, 1);
  data.number("eyes_alone", recipe.poses.eyes_alone, 0, 1);
  data.number("winks", recipe.poses.winks, 0, 1);
  data.number("closed_lips", recipe.poses.closed_lips, 0, 1);
  data.numbers("rates_hz", recipe.rates_hz, 1, 130);
  MIEN_TRY(data.finish());
  if (recipe.poses.eyes_alone + recipe.poses.winks + recipe.poses.closed_lips > 1)
    return fail(ErrorCode::out_of_range, "eyes_alone, winks and closed_lips are more than all poses", where);
  return recipe;
}

Result<HeadsetFilms> make_headset_films(const HeadsetDataRecipe& recipe, const sensor::Rig& rig,
                                        const std::filesystem::path& folder, const Progress& progress,
                                        unsigned threads) {
  MIEN_TRY_ASSIGN(const virt::HeadsetFaults faults, virt::parse_headset_faults(rig.faults_toml, rig.name));
  MIEN_TRY(virt::check_network_views(rig));
  const std::size_t training = static_cast<std::size_t>(recipe.wearers);
  const std::size_t all = training + static_cast<std::size_t>(recipe.validation_wearers);
  // A wearer's film does not depend on how many there are.
  Sha256 hashing;
  const std::string what = fmt::format(
      "film 5 {} {} {} {} {} {} {} {} {} {}\n{}", recipe.seed, recipe.donnings, recipe.frames,
      recipe.neutral_frames, fmt::join(recipe.rates_hz, ","), recipe.failing, recipe.side,
      recipe.poses.eyes_alone, recipe.poses.winks, recipe.poses.closed_lips, sensor::write_rig(rig));
  hashing.add(std::as_bytes(std::span(what)));
  const std::string hash = hashing.hex();
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code) return fail(ErrorCode::io, code.message(), folder.string());
  const auto path_of = [&](std::size_t index) {
    return folder / (index < training ? fmt::format("train_{:05}.film", index)
                                      : fmt::format("validation_{:05}.film", index - training));
  };
  MIEN_TRY(virt::for_each_performer(all, threads, progress, [&](std::size_t index) -> Result<void> {
    if (const auto standing = HeadsetFilm::open(path_of(index)); standing) {
      if (standing->hash() == hash) return {};
      return fail(ErrorCode::mismatch, "a film of another recipe or rig stands here", path_of(index).string(),
                  "name another folder, or remove this one");
    }
    const Random root = Random(recipe.seed)
                            .fork(index < training ? "wearer" : "validation wearer",
                                  index < training ? index : index - training);
    MIEN_TRY_ASSIGN(const std::vector<FilmFrame> frames, film_person(recipe, rig, faults, root));
    return write_film(path_of(index), hash, frames.front().views.size(),
                      static_cast<std::size_t>(recipe.side), frames);
  }));
  HeadsetFilms films;
  for (std::size_t index = 0; index < all; ++index) {
    MIEN_TRY_ASSIGN(HeadsetFilm film, HeadsetFilm::open(path_of(index)));
    (index < training ? films.train : films.validation).push_back(std::move(film));
  }
  return films;
}

}  // namespace mien::synthetic
