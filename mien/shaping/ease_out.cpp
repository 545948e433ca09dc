#include "mien/shaping/ease_out.h"

#include <algorithm>
#include <cmath>

#include "mien/shaping/bounds.h"

namespace mien::shaping {
namespace {

/// The ease-out ends after this many `return_s`, when 1e-5 of the difference is left; frames then pass
/// untouched.
constexpr double kDoneAfter = 3;

}  // namespace

void EaseOut::begin(std::size_t part, const face::OutputFrame& shown, const face::OutputFrame& next) {
  // From or to where nobody knows the position there is no difference: HeadPosition sees to it.
  if (part == kPositionPart && !(shown.head_position_known && next.head_position_known)) return stop(part);
  const std::size_t first = first_value(part);
  if (part < face::kShapeCount) {
    difference_[first] = static_cast<double>(shown.weights[part]) - next.weights[part];
  } else if (part == kTonguePart) {
    difference_[first] = static_cast<double>(shown.tongue_out) - next.tongue_out;
  } else if (part == kHeadPart) {
    const Vec3 head = log_rotation(shown.head * next.head.conjugate());
    for (std::size_t a = 0; a < 3; ++a) difference_[first + a] = head[static_cast<Eigen::Index>(a)];
  } else if (part == kEyesPart) {
    for (std::size_t e = 0; e < 2; ++e) {
      difference_[first + 2 * e] = shown.eyes_rad[e].x() - next.eyes_rad[e].x();
      difference_[first + 2 * e + 1] = shown.eyes_rad[e].y() - next.eyes_rad[e].y();
    }
  } else {
    const Vec3f position = shown.head_position_m - next.head_position_m;
    for (std::size_t a = 0; a < 3; ++a)
      difference_[first + a] = static_cast<double>(position[static_cast<Eigen::Index>(a)]);
  }
  since_[part] = shown.time;
  if (active_[part]) return;
  for (std::size_t i = first; i < first_value(part + 1); ++i) speed_[i] = 0;
  active_[part] = true;
  ++active_count_;
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
      const double pull = speed_[i] + omega * difference_[i];
      difference_[i] = (difference_[i] + pull * step_s) * fall;
      speed_[i] = (speed_[i] - omega * pull * step_s) * fall;
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
