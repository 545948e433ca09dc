#include "mien/shaping/recentre.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mien/core/smoothstep.h"

namespace mien::shaping {
namespace {

using face::Provenance;

constexpr double kMeasure_s = 1.0;
constexpr double kEase_s = 0.5;
/// Least number of observed frames of a measurement: half a second of the 60 Hz grid.
constexpr std::size_t kEnoughFrames = 30;
/// Least horizontal part of the forward direction: looking straight up or down the head has no heading.
constexpr double kLeastHorizontal = 0.2;

bool is_observed(Provenance p) {
  return p == Provenance::measured || p == Provenance::interpolated || p == Provenance::predicted;
}

/// The same angle in -pi to pi.
double wrapped(double angle) {
  return std::remainder(angle, 2 * std::numbers::pi);
}

}  // namespace

void Recentre::begin() {
  state_ = State::measuring;
  measuring_since_.reset();
  frames_ = 0;
  headings_ = 0;
  sum_x_ = 0;
  sum_z_ = 0;
  positions_ = 0;
  sum_position_m_.setZero();
}

void Recentre::use(const Centre& centre) {
  Centre bounded = centre;
  for (float& rest : bounded.rest)
    rest = std::isfinite(rest) ? std::clamp(rest, 0.0f, Centre::kRestAtMost) : 0.0f;
  bounded.yaw_rad = std::isfinite(centre.yaw_rad) ? wrapped(centre.yaw_rad) : 0;
  if (!bounded.position_m.allFinite()) bounded.position_m.setZero();
  constexpr double kMost_m = Centre::kPositionAtMost_m;
  bounded.position_m = bounded.position_m.cwiseMax(-kMost_m).cwiseMin(kMost_m).eval();
  go_to(bounded);
}

void Recentre::go_to(const Centre& centre) {
  from_ = present_;
  target_ = centre;
  easing_ = true;
  easing_since_.reset();
  state_ = State::easing;
}

void Recentre::settle() {
  if (easing_ || state_ == State::measuring) state_ = State::done;
  easing_ = false;
  present_ = target_;
}

void Recentre::observe(const face::OutputFrame& frame) {
  if (state_ == State::measuring) measure(frame);
  if (easing_) ease_on(frame.time);
}

void Recentre::ease_on(DeviceTime time) {
  if (!easing_since_) easing_since_ = time;
  const double u = to_seconds(time - *easing_since_) / kEase_s;
  if (u >= 1) {
    present_ = target_;
    easing_ = false;
    if (state_ == State::easing) state_ = State::done;
    return;
  }
  const double s = smoothstep(u);
  for (std::size_t i = 0; i < face::kShapeCount; ++i)
    present_.rest[i] = static_cast<float>(from_.rest[i] + s * (target_.rest[i] - from_.rest[i]));
  present_.yaw_rad = wrapped(from_.yaw_rad + s * wrapped(target_.yaw_rad - from_.yaw_rad));
  present_.position_m = from_.position_m + s * (target_.position_m - from_.position_m);
}

void Recentre::measure(const face::OutputFrame& frame) {
  if (!measuring_since_) measuring_since_ = frame.time;
  if (std::ranges::any_of(frame.provenance, is_observed)) {
    for (std::size_t i = 0; i < face::kShapeCount; ++i) seen_[i][frames_] = frame.weights[i];
    ++frames_;
  }
  if (is_observed(frame.head_provenance)) {
    const Vec3 forward = frame.head * Vec3::UnitZ();
    if (std::hypot(forward.x(), forward.z()) > kLeastHorizontal) {
      sum_x_ += forward.x();
      sum_z_ += forward.z();
      ++headings_;
    }
    if (frame.head_position_known) {
      sum_position_m_ += frame.head_position_m.cast<double>();
      ++positions_;
    }
  }
  if (frames_ == kMostFrames || to_seconds(frame.time - *measuring_since_) >= kMeasure_s) conclude();
}

void Recentre::conclude() {
  performed_ = 0;
  const bool shapes = frames_ >= kEnoughFrames;
  if (!shapes && headings_ < kEnoughFrames && positions_ < kEnoughFrames) {
    state_ = State::failed;
    return;
  }
  Centre centre = target_;
  for (std::size_t i = 0; shapes && i < face::kShapeCount; ++i) {
    const auto first = seen_[i].begin();
    const auto third = first + static_cast<std::ptrdiff_t>(frames_ / 3);
    std::nth_element(first, third, first + static_cast<std::ptrdiff_t>(frames_));
    if (*third <= Centre::kRestAtMost)
      centre.rest[i] = *third;
    else
      ++performed_;
  }
  if (headings_ >= kEnoughFrames) centre.yaw_rad = std::atan2(sum_x_, sum_z_);
  if (positions_ >= kEnoughFrames) centre.position_m = sum_position_m_ / static_cast<double>(positions_);
  go_to(centre);
}

void Recentre::take_off(face::OutputFrame& frame, const RestingFace& applied) const {
  for (std::size_t i = 0; i < face::kShapeCount; ++i) {
    const float rest = applied.applied(i, present_.rest[i]);
    if (rest > 0) frame.weights[i] = std::clamp((frame.weights[i] - rest) / (1 - rest), 0.0f, 1.0f);
  }
  const Quat turn = exp_rotation({0, -present_.yaw_rad, 0});
  if (present_.yaw_rad != 0) frame.head = canonical(turn * frame.head);
  if (!frame.head_position_known || (present_.yaw_rad == 0 && present_.position_m.isZero(0))) return;
  frame.head_position_m = (turn * (frame.head_position_m.cast<double>() - present_.position_m)).cast<float>();
}

}  // namespace mien::shaping
