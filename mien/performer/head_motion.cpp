#include "mien/performer/head_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "mien/core/units.h"
#include "mien/performer/canvas.h"

namespace mien::performer {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kLargest_rad = 20 * kRadPerDeg;  // Of nods and turns.
constexpr double kCrossfade_s = 1.0;
// The joint about which heads nod, seen from the head origin between the ears: the upper neck.
const Vec3 kNeck_m(0, -0.11, -0.04);

/// Accumulates one activity over its episode.
struct Stage {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::vector<Vec3>& angle;     // (pitch, yaw, roll), rad.
  std::vector<Vec3>& position;  // m, about the walked way.
  std::vector<Vec3>& velocity;  // m/s, of the walk itself.
  double liveliness = 1;        // Scales talk.

  [[nodiscard]] double time_s(std::size_t i) const { return static_cast<double>(i - begin) / kFrameRateHz; }
  [[nodiscard]] double duration_s() const { return time_s(end); }
  /// Fades the episode in and out.
  [[nodiscard]] double share(std::size_t i) const {
    return minimum_jerk(time_s(i) / kCrossfade_s) * minimum_jerk((duration_s() - time_s(i)) / kCrossfade_s);
  }
};

void nod(const Stage& stage, Random& random) {
  double start = random.uniform(0, 0.5);
  while (start < stage.duration_s()) {
    const double rate_hz = random.uniform(0.4, 1.2);
    const double cycles = 1 + static_cast<double>(random.below(4));
    const double seconds = cycles / rate_hz;
    const double size = std::min(random.uniform(5, 20) * kRadPerDeg, kLargest_rad);
    const double slant = 0.1 * random.normal();
    const double ramp_s = 0.5 / rate_hz;
    for (std::size_t i = stage.begin; i < stage.end; ++i) {
      const double t = stage.time_s(i) - start;
      if (t < 0 || t > seconds) continue;
      const double window = minimum_jerk(t / ramp_s) * minimum_jerk((seconds - t) / ramp_s);
      const double now = stage.share(i) * window * size * std::sin(kTurn * rate_hz * t);
      stage.angle[i] += Vec3(now, slant * now, 0.5 * slant * now);
    }
    start += seconds + random.uniform(0.1, 1.0);
  }
}

void turn(const Stage& stage, Random& random) {
  // Moves from pose to pose, each a turn with some nod and tilt.
  Vec3 from = Vec3::Zero();
  std::size_t i = stage.begin;
  while (i < stage.end) {
    Vec3 to = Vec3::Zero();
    if (!random.chance(0.2)) {
      const double size = random.uniform(6, 20) * kRadPerDeg;
      const double which = random.uniform();
      const double sign = random.chance(0.5) ? 1 : -1;
      to = which < 0.55 ? Vec3{0.2 * random.normal() * size, sign * size, 0.15 * random.normal() * size}
           : which < 0.8
               ? Vec3{sign * size, 0.2 * random.normal() * size, 0.1 * random.normal() * size}
               : Vec3{0.1 * random.normal() * size, 0.2 * random.normal() * size, 0.7 * sign * size};
    }
    to = to.cwiseMax(-kLargest_rad).cwiseMin(kLargest_rad);
    const double move_s = random.uniform(0.35, 1.4);
    const double hold_s = random.uniform(0.0, 1.2);
    const auto frames = static_cast<std::size_t>(std::ceil((move_s + hold_s) * kFrameRateHz));
    for (std::size_t j = 0; j < frames && i < stage.end; ++j, ++i) {
      const double u = minimum_jerk(static_cast<double>(j) / kFrameRateHz / move_s);
      stage.angle[i] += stage.share(i) * (from + u * (to - from));
    }
    from = to;
  }
}

void talk(const Stage& stage, Random& random) {
  std::array<SmoothNoise, 3> slow = {SmoothNoise(0.25, random), SmoothNoise(0.25, random),
                                     SmoothNoise(0.2, random)};
  std::array<SmoothNoise, 3> quick = {SmoothNoise(1.2, random), SmoothNoise(1.0, random),
                                      SmoothNoise(0.8, random)};
  const Vec3 slow_deg(2.5, 3.0, 2.0);
  const Vec3 quick_deg(1.0, 0.7, 0.5);
  for (std::size_t i = stage.begin; i < stage.end; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      stage.angle[i][a] += stage.share(i) * stage.liveliness * kRadPerDeg *
                           (slow_deg[a] * slow[axis].next(random) + quick_deg[a] * quick[axis].next(random));
    }
}

/// One quick shake or nod of some cycles from `begin_s`. Gives its length, s.
double shake(const Stage& stage, double begin_s, Random& random) {
  const double rate_hz = random.uniform(2.0, 3.2);
  const double seconds = static_cast<double>(2 + random.below(4)) / rate_hz;
  const double size = random.uniform(6, 18) * kRadPerDeg;
  const Vec3 axis =
      random.chance(0.6) ? Vec3(0.1 * random.normal(), 1, 0.1) : Vec3(0.6, 0.1 * random.normal(), 0);
  for (std::size_t i = stage.begin; i < stage.end; ++i) {
    const double t = stage.time_s(i) - begin_s;
    if (t < 0 || t > seconds) continue;
    const double window = minimum_jerk(2 * rate_hz * t) * minimum_jerk(2 * rate_hz * (seconds - t));
    stage.angle[i] += stage.share(i) * window * size * std::sin(kTurn * rate_hz * t) * axis;
  }
  return seconds;
}

void dart(const Stage& stage, Random& random) {
  constexpr double kFastestRadS = 400 * kRadPerDeg;
  constexpr double kPeakOverMean = 1.875;  // Of a minimum jerk's speed.
  const Vec3 most = Vec3(30, 45, 20) * kRadPerDeg;
  Vec3 from = Vec3::Zero();
  double now_s = 0;
  while (now_s < stage.duration_s()) {
    Vec3 to = Vec3::Zero();
    if (!random.chance(0.25))
      for (Eigen::Index a = 0; a < 3; ++a) to[a] = random.uniform(-1, 1) * most[a];
    const double move_s =
        std::max(random.uniform(0.16, 0.4), kPeakOverMean * (to - from).norm() / kFastestRadS);
    double hold_s = random.uniform(0.05, 0.8);
    if (random.chance(0.3)) hold_s = shake(stage, now_s + move_s, random);
    for (std::size_t i = stage.begin; i < stage.end; ++i) {
      const double t = stage.time_s(i) - now_s;
      if (t < 0 || t >= move_s + hold_s) continue;
      stage.angle[i] += stage.share(i) * (from + minimum_jerk(t / move_s) * (to - from));
    }
    now_s += move_s + hold_s;
    from = to;
  }
}

/// How a body carries the head at each step: between what each is drawn.
struct Gait {
  using Range = std::array<double, 2>;
  Range steps_hz;
  Range bounce_m;  ///< Half of the way up and down.
  Range shock_m;   ///< The same of the second harmonic.
  Range sway_m;    ///< Sideways, at half the rate of steps.
  Range surge_m;   ///< Forward and back.
  Range pitch_deg;
  Range speed_m_s;
};
constexpr Gait kWalk = {{1.7, 2.1},     {0.016, 0.026}, {0.001, 0.003}, {0.012, 0.025},
                        {0.004, 0.012}, {0.5, 2.0},     {1.1, 1.5}};
constexpr Gait kRun = {{2.6, 3.0},     {0.030, 0.045}, {0.004, 0.008}, {0.010, 0.020},
                       {0.008, 0.016}, {1.0, 3.0},     {2.5, 3.5}};

template <const Gait& gait>
void step_along(const Stage& stage, Random& random) {
  const auto drawn = [&](const Gait::Range& range) { return random.uniform(range[0], range[1]); };
  const double steps_hz = drawn(gait.steps_hz), bounce_m = drawn(gait.bounce_m);
  const double shock_m = drawn(gait.shock_m), sway_m = drawn(gait.sway_m), surge_m = drawn(gait.surge_m);
  const double pitch_rad = drawn(gait.pitch_deg) * kRadPerDeg, speed_m_s = drawn(gait.speed_m_s);
  SmoothNoise tempo(0.3, random);
  SmoothNoise size(0.4, random);
  SmoothNoise path(0.08, random);
  SmoothNoise look(0.3, random);
  double phase = random.uniform();
  const double lag = random.uniform(0, 1);
  const double shock_lag = random.uniform(0.2, 0.4);
  const double tilt = random.uniform(0.3, 1.2) * kRadPerDeg;
  for (std::size_t i = stage.begin; i < stage.end; ++i) {
    const double share = stage.share(i);
    phase += steps_hz * (1 + 0.03 * tempo.next(random)) / kFrameRateHz;
    const double strength = share * (1 + 0.1 * size.next(random));
    const double step = kTurn * phase;
    const double stride = 0.5 * step;
    // The path bends, and the head looks a little aside of it.
    const double heading = share * 15 * kRadPerDeg * path.next(random);
    const Vec3 forward(std::sin(heading), 0, std::cos(heading));
    const Vec3 left(std::cos(heading), 0, -std::sin(heading));
    const double up = bounce_m * std::sin(step) + shock_m * std::sin(2 * (step + kTurn * shock_lag));
    stage.position[i] += strength * (Vec3(0, up, 0) + sway_m * std::sin(stride + kTurn * lag) * left +
                                     surge_m * std::sin(step + 1.1) * forward);
    stage.angle[i] +=
        Vec3(strength * pitch_rad * std::sin(step + kTurn * lag),
             heading + share * 3 * kRadPerDeg * look.next(random) + strength * tilt * std::sin(stride),
             strength * 0.6 * tilt * std::sin(stride + 0.7));
    stage.velocity[i] += share * speed_m_s * forward;
  }
}

void keep_still(const Stage&, Random&) {}

/// By HeadActivity.
constexpr std::array kActivities = {keep_still, nod, turn, talk, step_along<kWalk>, step_along<kRun>, dart};

}  // namespace

Quat head_orientation(const Vec3& pitch_yaw_roll_rad) {
  return Quat(Eigen::AngleAxisd(pitch_yaw_roll_rad.y(), Vec3::UnitY()) *
              Eigen::AngleAxisd(pitch_yaw_roll_rad.x(), Vec3::UnitX()) *
              Eigen::AngleAxisd(pitch_yaw_roll_rad.z(), Vec3::UnitZ()));
}

Vec3 neck_displacement_m(const Quat& q_world_head) {
  return kNeck_m - q_world_head * kNeck_m;
}

HeadTrack draw_head_motion(std::size_t frame_count, std::span<const HeadEpisode> episodes, double liveliness,
                           std::span<const Vec3> extra_rad, Random random) {
  std::vector<Vec3> angle(frame_count, Vec3::Zero());
  std::vector<Vec3> position(frame_count, Vec3::Zero());
  std::vector<Vec3> velocity(frame_count, Vec3::Zero());
  const auto frame_at = [&](double time_s) {
    return static_cast<std::size_t>(
        std::clamp(std::round(time_s * kFrameRateHz), 0.0, static_cast<double>(frame_count)));
  };
  for (std::size_t e = 0; e < episodes.size(); ++e) {
    const std::size_t begin = frame_at(episodes[e].begin_s);
    const double next_s = e + 1 < episodes.size() ? episodes[e + 1].begin_s : 1e12;
    // Neighbours overlap while one fades out and the other in.
    const std::size_t end = frame_at(next_s + kCrossfade_s);
    if (begin >= end) continue;
    Random own = random.fork("episode", e);
    kActivities[static_cast<std::size_t>(episodes[e].activity)](
        {begin, end, angle, position, velocity, liveliness}, own);
  }
  // Nobody's head is quite still.
  Random sway_random = random.fork("sway");
  std::array<SmoothNoise, 3> sway = {SmoothNoise(0.25, sway_random), SmoothNoise(0.25, sway_random),
                                     SmoothNoise(0.2, sway_random)};
  HeadTrack track;
  track.orientation.reserve(frame_count);
  track.position_m.reserve(frame_count);
  Vec3 walked = Vec3::Zero();
  for (std::size_t i = 0; i < frame_count; ++i) {
    for (auto& noise : sway) {
      const auto axis = static_cast<Eigen::Index>(&noise - sway.data());
      angle[i][axis] += 0.25 * liveliness * kRadPerDeg * noise.next(sway_random);
    }
    if (!extra_rad.empty()) angle[i] += extra_rad[i];
    const Quat q = head_orientation(angle[i]);
    track.orientation.push_back(q);
    track.position_m.push_back(walked + position[i] + neck_displacement_m(q));
    walked += velocity[i] / kFrameRateHz;
  }
  return track;
}

std::vector<HeadEpisode> default_head_episodes(double duration_s, Random random) {
  const double walk_s = std::min(60.0, 0.5 * duration_s);
  const double walk_begin_s = random.uniform(0, duration_s - walk_s);
  std::vector<HeadEpisode> episodes;
  double now_s = 0;
  bool walked = false;
  while (now_s < duration_s) {
    if (!walked && now_s >= walk_begin_s) {
      episodes.push_back({now_s, HeadActivity::walking});
      now_s += walk_s;
      walked = true;
      continue;
    }
    const double which = random.uniform();
    const HeadActivity activity = which < 0.3   ? HeadActivity::still
                                  : which < 0.6 ? HeadActivity::nodding
                                                : HeadActivity::turning;
    episodes.push_back({now_s, activity});
    const double next_s = now_s + random.uniform(3, 9);
    now_s = walked ? next_s : std::min(next_s, std::max(walk_begin_s, now_s + 0.1));
  }
  return episodes;
}

face::Motion with_head_motion(const face::Motion& motion, Random random) {
  if (motion.frames.empty()) return motion;
  const double duration_s = motion.frames.back().time_s - motion.frames.front().time_s;
  return with_head_motion(motion, default_head_episodes(duration_s, random.fork("episodes")), random);
}

face::Motion with_head_motion(const face::Motion& motion, std::span<const HeadEpisode> episodes,
                              const Random& random) {
  face::Motion out = motion;
  if (out.frames.empty()) return out;
  const double begin_s = out.frames.front().time_s;
  const double duration_s = out.frames.back().time_s - begin_s;
  const auto frame_count = static_cast<std::size_t>(std::ceil(duration_s * kFrameRateHz)) + 2;
  const HeadTrack track = draw_head_motion(frame_count, episodes, 1.0, {}, random.fork("head"));
  for (auto& frame : out.frames) {
    const double at = (frame.time_s - begin_s) * kFrameRateHz;
    const auto i = std::min(static_cast<std::size_t>(at), frame_count - 2);
    const double u = at - static_cast<double>(i);
    frame.head = track.orientation[i].slerp(u, track.orientation[i + 1]);
    frame.head_position_m = (1 - u) * track.position_m[i] + u * track.position_m[i + 1];
  }
  out.has_head = true;
  out.head_without_face = true;
  return out;
}

}  // namespace mien::performer
