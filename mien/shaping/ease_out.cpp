#include "mien/shaping/ease_out.h"

#include <algorithm>
#include <cmath>

#include "mien/shaping/bounds.h"

namespace mien::shaping {
namespace {

/// The ease-out ends after this many `return_s`, when 1e-6 of the difference is left; frames then pass
/// untouched.
constexpr double kDoneAfter = 3;

}  // namespace

EaseOut::PartValues EaseOut::offset_of(std::size_t part, const face::OutputFrame& shown,
                                       const face::OutputFrame& next) {
  PartValues offset{};
  if (part < face::kShapeCount) {
    offset[0] = static_cast<double>(shown.weights[part]) - next.weights[part];
  } else if (part == kTonguePart) {
    offset[0] = static_cast<double>(shown.tongue_out) - next.tongue_out;
  } else if (part == kHeadPart) {
    const Vec3 head = log_rotation(shown.head * next.head.conjugate());
    for (std::size_t a = 0; a < 3; ++a) offset[a] = head[static_cast<Eigen::Index>(a)];
  } else if (part == kEyesPart) {
    for (std::size_t e = 0; e < 2; ++e) {
      offset[2 * e] = shown.eyes_rad[e].x() - next.eyes_rad[e].x();
      offset[2 * e + 1] = shown.eyes_rad[e].y() - next.eyes_rad[e].y();
    }
  } else {
    const Vec3f position = shown.head_position_m - next.head_position_m;
    for (std::size_t a = 0; a < 3; ++a)
      offset[a] = static_cast<double>(position[static_cast<Eigen::Index>(a)]);
  }
  return offset;
}

void EaseOut::begin(std::size_t part, const face::OutputFrame& shown, const face::OutputFrame& next) {
  // From or to where nobody knows the position there is no difference: HeadPosition sees to it.
  if (part == kPositionPart && !(shown.head_position_known && next.head_position_known)) return stop(part);
  const PartValues offset = offset_of(part, shown, next);
  const std::size_t first = first_value(part), count = first_value(part + 1) - first;
  for (std::size_t i = 0; i < count; ++i) difference_[first + i] = offset[i];
  since_[part] = shown.time;
  if (active_[part]) return;
  for (std::size_t i = first; i < first + count; ++i) speed_[i] = acceleration_[i] = 0;
  active_[part] = true;
  ++active_count_;
}

void EaseOut::begin_moving(std::size_t part, const Course& shown, const Course& next, double step_s) {
  begin(part, shown.now, next.now);
  if (!active_[part] ||
      (part == kPositionPart && !(shown.before.head_position_known && next.before.head_position_known)))
    return;
  const PartValues before = offset_of(part, shown.before, next.before);
  const std::size_t first = first_value(part), count = first_value(part + 1) - first;
  for (std::size_t i = 0; i < count; ++i) {
    speed_[first + i] = (difference_[first + i] - before[i]) / step_s;
    acceleration_[first + i] = 0;
  }
}

void EaseOut::begin_all(const face::OutputFrame& shown, const face::OutputFrame& next) {
  for (std::size_t part = 0; part < kPartCount; ++part) begin(part, shown, next);
}

void EaseOut::stop(std::size_t part) {
  if (!active_[part]) return;
  active_[part] = false;
  --active_count_;
}

void EaseOut::stop() {
  active_.fill(false);
  active_count_ = 0;
}

void EaseOut::apply(face::OutputFrame& frame, double step_s, double return_s) {
  if (!active()) return;
  const double omega = kConstantsTo5Percent / return_s;
  const double fall = std::exp(-omega * step_s);
  for (std::size_t part = 0; part < kPartCount; ++part) {
    if (!active_[part]) continue;
    if (to_seconds(frame.time - since_[part]) >= kDoneAfter * return_s ||
        (part == kPositionPart && !frame.head_position_known)) {
      stop(part);
      continue;
    }
    const std::size_t first = first_value(part);
    for (std::size_t i = first; i < first_value(part + 1); ++i) {
      // The offset is a polynomial of second degree times exp(-omega t): this is its next value, exactly.
      const double linear = speed_[i] + omega * difference_[i];
      const double square = 0.5 * (acceleration_[i] + omega * (2 * speed_[i] + omega * difference_[i]));
      const double value = difference_[i] + (linear + square * step_s) * step_s;
      const double slope = linear + 2 * square * step_s;
      difference_[i] = value * fall;
      speed_[i] = (slope - omega * value) * fall;
      acceleration_[i] = (2 * square - omega * (2 * slope - omega * value)) * fall;
    }
    if (part < face::kShapeCount) {
      frame.weights[part] =
          std::clamp(static_cast<float>(frame.weights[part] + difference_[first]), 0.0F, 1.0F);
    } else if (part == kTonguePart) {
      frame.tongue_out = std::clamp(static_cast<float>(frame.tongue_out + difference_[first]), 0.0F, 1.0F);
    } else if (part == kHeadPart) {
      const Vec3 head(difference_[first], difference_[first + 1], difference_[first + 2]);
      frame.head = canonical(exp_rotation(head) * frame.head);
    } else if (part == kPositionPart) {
      const Vec3 left(difference_[first], difference_[first + 1], difference_[first + 2]);
      frame.head_position_m += left.cast<float>();
    } else {
      for (std::size_t e = 0; e < 2; ++e) {
        const Eigen::Vector2d left(difference_[first + 2 * e], difference_[first + 2 * e + 1]);
        frame.eyes_rad[e] =
            (frame.eyes_rad[e] + left.cast<float>()).cwiseMax(-kEyeAtMostRad).cwiseMin(kEyeAtMostRad);
      }
    }
  }
}

}  // namespace mien::shaping
