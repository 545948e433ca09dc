#include "mien/performer/gaze_points.h"

#include <array>
#include <cmath>

#include "mien/core/time.h"
#include "mien/core/units.h"
#include "mien/performer/blinks.h"
#include "mien/performer/canvas.h"
#include "mien/performer/gaze.h"

namespace mien::performer {
namespace {

constexpr double kEarliest_s = 0.2, kLatest_s = 0.5;
constexpr double kOff_rad = 0.5 * kRadPerDeg;
constexpr double kDrift_rad = 0.1 * kRadPerDeg;
constexpr double kDrift_hz = 1;
/// Main sequence (Carpenter 1988): 21 ms and 2.2 ms a degree.
constexpr double kSaccade_s = 0.021, kSaccade_s_per_rad = 0.0022 / kRadPerDeg;
constexpr double kBlinksPerMin = 12;

}  // namespace

std::vector<face::BlendshapeWeights> look_at_targets(std::span<const face::GazeTarget> targets, double each_s,
                                                     const Random& random) {
  const double length_s = each_s * static_cast<double>(targets.size());
  const auto count = static_cast<std::size_t>(std::round(length_s * kFrameRateHz));
  std::vector<face::BlendshapeWeights> weights(count);
  Random eyes = random.fork("eyes");
  std::array drift = {SmoothNoise(kDrift_hz, eyes), SmoothNoise(kDrift_hz, eyes)};
  Eigen::Vector2d from = Eigen::Vector2d::Zero(), to = from;
  std::size_t next = 0;
  double turns_s = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / kFrameRateHz;
    if (next < targets.size() && t >= each_s * static_cast<double>(next)) {
      from = to;
      to = targets[next].direction_rad.cast<double>() +
           kOff_rad * Eigen::Vector2d(eyes.normal(), eyes.normal());
      turns_s = each_s * static_cast<double>(next) + eyes.uniform(kEarliest_s, kLatest_s);
      ++next;
    }
    const double saccade_s = kSaccade_s + kSaccade_s_per_rad * (to - from).norm();
    const Eigen::Vector2d looks = from + minimum_jerk((t - turns_s) / saccade_s) * (to - from) +
                                  kDrift_rad * Eigen::Vector2d(drift[0].next(eyes), drift[1].next(eyes));
    set_eye_look(weights[i], looks.cast<float>(), 0);
  }
  const auto lids = lid_tracks(draw_blinks(length_s, kBlinksPerMin, {}, random.fork("blinks")), count);
  for (std::size_t i = 0; i < count; ++i) {
    weights[i][face::shape("eyeBlink_L")] = lids[i][0];
    weights[i][face::shape("eyeBlink_R")] = lids[i][1];
  }
  return weights;
}

}  // namespace mien::performer
