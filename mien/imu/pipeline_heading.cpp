#include <cmath>
#include <numbers>
#include <utility>

#include "mien/imu/pipeline_state.h"

namespace mien::imu {
namespace {

/// Standard deviation of a heading that was aligned by the neutral, since the face may not be at it, rad (10
/// deg).
constexpr double kRealignedSigma_rad = 0.17;
/// Skin turns less than this about the vertical, rad (120 deg); a heading that implies more for this long, s
/// (in which a tilt spoilt by a gap is corrected), is lost. docs/experiments/fusion.md, lost headings.
constexpr double kMostSkinTurn_rad = 2.1;
constexpr double kImplausibleFor_s = 0.25;

}  // namespace

Quat Pipeline::State::relative(std::size_t i, const Quat& q_world_ear) const {
  return q_world_ear.conjugate() * turn_of(i) * poses[i]->orientation;
}

void Pipeline::State::measure_turns(const Quat& q_world_ear) {
  const Quat c = q_head_ear();
  for (std::size_t i = 0; i < face.size(); ++i) {
    turns_rad[i].reset();
    if (poses[i])
      turns_rad[i] = log_rotation(c * relative(i, q_world_ear) * neutral(i).conjugate() * c.conjugate());
  }
  last_up = c * (q_world_ear.conjugate() * Vec3::UnitY());
}

bool Pipeline::State::follow_rest(DeviceTime frame) {
  rested.reset();
  if (!rest || frame < rest->begin) return false;
  if (frame < rest->end) {
    if (!std::exchange(rest->begun, true)) rest_measurement.begin();
    return true;
  }
  if (rest->begun) conclude_rest();
  rest.reset();
  return false;
}

void Pipeline::State::conclude_rest() {
  if (!follows_drift()) return;
  tracker::RestOutcome& outcome = rested.emplace();
  std::vector<std::optional<Vec3>> still_rad(face.size());
  std::vector<double> sigma_rad(face.size());
  for (std::size_t i = 0; i < face.size(); ++i) {
    sigma_rad[i] = std::sqrt(settings.rest.sigma_rad * settings.rest.sigma_rad + tilt_rad2[i]);
    const std::optional<Vec3> turn_rad = rest_measurement.turn_rad(i);
    if (!turn_rad || !calibration.sensors[i].valid) {
      outcome.absent.push_back(face[i]);
    } else if (rest_measurement.scatter_rad(i) > settings.rest.moved_rad) {
      outcome.moved.push_back(face[i]);
    } else {
      outcome.corrected.push_back(face[i]);
      still_rad[i] = turn_rad;
    }
  }
  if (outcome.corrected.empty()) return;
  drift.observe_rest(still_rad, sigma_rad, rest_measurement.up());
  for (NodWatch& nod : nods) nod.interrupt();
}

// A restarted board has a new heading but sits where it sat: the heading that brings its skin nearest to
// neutral is off by no more than an expression, which the drift filter corrects.
double Pipeline::State::nearest_neutral(std::size_t i, const FusedSample& ear,
                                        const FusedSample& sensor) const {
  // trace(N^T R_h^T Z R_i) = a + b cos + c sin.
  const Mat3 to = (ear.orientation * neutral(i)).toRotationMatrix();
  const Mat3 from = sensor.orientation.toRotationMatrix();
  const double cosine = to.row(0).dot(from.row(0)) + to.row(2).dot(from.row(2));
  const double sine = to.row(0).dot(from.row(2)) - to.row(2).dot(from.row(0));
  return std::atan2(sine, cosine);
}

void Pipeline::State::realign_face(std::size_t i, const FusedSample& ear, const FusedSample& sensor) {
  move_heading(i, nearest_neutral(i, ear, sensor), kRealignedSigma_rad);
  channels[face[i]].restarted = false;
}

bool Pipeline::State::implausible(std::size_t i, double dt_s, const FusedSample& ear,
                                  const FusedSample& sensor) {
  const double off =
      std::remainder(nearest_neutral(i, ear, sensor) - drift.heading_rad(i), 2 * std::numbers::pi);
  implausible_s[i] = std::abs(off) > kMostSkinTurn_rad ? implausible_s[i] + dt_s : 0;
  if (implausible_s[i] <= kImplausibleFor_s) return implausible_s[i] > 0;
  realign_face(i, ear, sensor);
  implausible_s[i] = 0;
  return false;
}

void Pipeline::State::realign_head(DeviceTime frame, const FusedSample& ear) {
  // All headings against the head have changed by the same angle.
  double cosine = 0, sine = 0;
  bool restarted = false;
  for (std::size_t i = 0; i < face.size(); ++i) {
    if (!calibration.sensors[i].valid) continue;
    const auto sensor = pose(face[i], frame);
    if (!sensor) continue;
    if (channels[face[i]].restarted) {
      restarted = true;
      continue;
    }
    const double turned = nearest_neutral(i, ear, *sensor) - drift.heading_rad(i);
    cosine += std::cos(turned);
    sine += std::sin(turned);
  }
  if (cosine == 0 && sine == 0) {
    if (!restarted) return;  // No face sensor present yet.
    // All present sensors restarted with it, as when a mask is switched off: each is aligned by its neutral.
    for (const std::uint16_t s : face) channels[s].restarted = true;
  }
  const double turned = std::atan2(sine, cosine);
  drift.turn_all(turned, kRealignedSigma_rad);
  for (NodWatch& nod : nods) nod.interrupt();
  rest_measurement.begin();
  // The head keeps its last yaw.
  const Vec3 ahead = ear.orientation * (calibration.q_head_ear.conjugate() * Vec3::UnitZ());
  const Vec3 faced = last_head * Vec3::UnitZ();
  calibration.neutral_heading_rad = std::remainder(
      std::atan2(ahead.x(), ahead.z()) - std::atan2(faced.x(), faced.z()), 2 * std::numbers::pi);
  channels[*head].restarted = false;
}

}  // namespace mien::imu
