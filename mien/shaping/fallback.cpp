#include "mien/shaping/fallback.h"

#include <algorithm>
#include <cmath>

#include "mien/shaping/bounds.h"
#include "mien/shaping/ease.h"

namespace mien::shaping {
namespace {

using face::Provenance;

/// A critically damped spring that begins at rest has 5 % of its way left at this many of its time constants.
constexpr double kConstantsTo5Percent = 4.744;
/// And a hundred-thousandth after three times that: from there on the tracker's frame passes untouched.
constexpr double kDoneAfter = 3;

}  // namespace

Fallback::Fallback(const FallbackSettings& settings) : shown_(neutral_frame({})), from_(neutral_frame({})) {
  set(settings);
}

void Fallback::set(const FallbackSettings& settings) {
  const auto within = [](double x, double least) {
    return x > least ? std::min(x, FallbackSettings::kLongest_s) : least;  // Not a number: the least.
  };
  settings_.hold_s = within(settings.hold_s, 0);
  settings_.neutral_s = within(settings.neutral_s, FallbackSettings::kShortest_s);
  settings_.return_s = within(settings.return_s, FallbackSettings::kShortest_s);
}

void Fallback::apply(face::OutputFrame& frame, std::size_t sensors_there) {
  if (sensors_there == 0)
    lose(frame);
  else
    follow(frame, sensors_there);
  shown_ = frame;
}

void Fallback::lose(face::OutputFrame& frame) {
  if (phase_ != Phase::lost) {
    from_ = shown_;
    since_ = phase_ == Phase::waiting ? frame.time : shown_.time;
    phase_ = Phase::lost;
    letting_go_ = false;
  }
  const double age_s = to_seconds(frame.time - since_);
  const double gone = ease((age_s - settings_.hold_s) / settings_.neutral_s);
  const auto sure =
      static_cast<float>(std::clamp(1 - age_s / (settings_.hold_s + settings_.neutral_s), 0.0, 1.0));
  const auto told = [&](Provenance was) {
    return was == Provenance::neutral || age_s > settings_.hold_s ? Provenance::neutral : Provenance::held;
  };
  const auto left = static_cast<float>(1 - gone);
  for (std::size_t i = 0; i < face::kShapeCount; ++i) {
    frame.weights[i] = left * from_.weights[i];
    frame.confidence[i] = sure * from_.confidence[i];
    frame.provenance[i] = told(from_.provenance[i]);
  }
  frame.tongue_out = left * from_.tongue_out;
  const Quat upright = twist_about(from_.head, Vec3::UnitY());
  frame.head =
      gone > 0 ? canonical(exp_rotation(gone * log_rotation(upright * from_.head.conjugate())) * from_.head)
               : from_.head;
  frame.head_confidence = sure * from_.head_confidence;
  frame.head_provenance = told(from_.head_provenance);
  for (std::size_t e = 0; e < 2; ++e) frame.eyes_rad[e] = left * from_.eyes_rad[e];
  frame.eyes_confidence = sure * from_.eyes_confidence;
  frame.eyes_provenance = told(from_.eyes_provenance);
}

void Fallback::follow(face::OutputFrame& frame, std::size_t sensors_there) {
  if (phase_ == Phase::lost) {
    from_ = shown_;
    returning_ = true;
    speed_.fill(0);
    take_difference(frame);
  } else if (phase_ == Phase::following && sensors_there != sensors_there_) {
    if (!letting_go_) {
      returning_ = false;
      speed_.fill(0);
    }
    take_difference(frame);
  }
  phase_ = Phase::following;
  sensors_there_ = sensors_there;
  if (letting_go_) let_go(frame);
}

void Fallback::take_difference(const face::OutputFrame& frame) {
  for (std::size_t i = 0; i < face::kShapeCount; ++i)
    difference_[i] = static_cast<double>(shown_.weights[i]) - frame.weights[i];
  difference_[kTongue] = static_cast<double>(shown_.tongue_out) - frame.tongue_out;
  const Vec3 head = log_rotation(shown_.head * frame.head.conjugate());
  for (int a = 0; a < 3; ++a) difference_[kHead + static_cast<std::size_t>(a)] = head[a];
  for (std::size_t e = 0; e < 2; ++e) {
    difference_[kEyes + 2 * e] = shown_.eyes_rad[e].x() - frame.eyes_rad[e].x();
    difference_[kEyes + 2 * e + 1] = shown_.eyes_rad[e].y() - frame.eyes_rad[e].y();
  }
  since_ = shown_.time;
  letting_go_ = true;
}

void Fallback::let_go(face::OutputFrame& frame) {
  const double age_s = to_seconds(frame.time - since_);
  if (age_s >= kDoneAfter * settings_.return_s) {
    letting_go_ = false;
    return;
  }
  const double omega = kConstantsTo5Percent / settings_.return_s;
  const double step_s = to_seconds(frame.time - shown_.time);
  const double fall = std::exp(-omega * step_s);
  for (std::size_t i = 0; i < difference_.size(); ++i) {
    const double pull = speed_[i] + omega * difference_[i];
    difference_[i] = (difference_[i] + pull * step_s) * fall;
    speed_[i] = (speed_[i] - omega * pull * step_s) * fall;
  }
  for (std::size_t i = 0; i < face::kShapeCount; ++i)
    frame.weights[i] = std::clamp(static_cast<float>(frame.weights[i] + difference_[i]), 0.0f, 1.0f);
  frame.tongue_out = std::clamp(static_cast<float>(frame.tongue_out + difference_[kTongue]), 0.0f, 1.0f);
  const Vec3 head(difference_[kHead], difference_[kHead + 1], difference_[kHead + 2]);
  frame.head = canonical(exp_rotation(head) * frame.head);
  for (std::size_t e = 0; e < 2; ++e) {
    const Eigen::Vector2d away(difference_[kEyes + 2 * e], difference_[kEyes + 2 * e + 1]);
    frame.eyes_rad[e] =
        (frame.eyes_rad[e] + away.cast<float>()).cwiseMax(-kEyeAtMostRad).cwiseMin(kEyeAtMostRad);
  }
  if (!returning_) return;
  // Confidence comes with the tracker's share of what is shown, provenance with its larger half.
  const double back = 1 - (1 + omega * age_s) * std::exp(-omega * age_s);
  const auto sure = static_cast<float>(back);
  for (std::size_t i = 0; i < face::kShapeCount; ++i) {
    frame.confidence[i] *= sure;
    if (back < 0.5) frame.provenance[i] = from_.provenance[i];
  }
  frame.head_confidence *= sure;
  frame.eyes_confidence *= sure;
  if (back < 0.5) {
    frame.head_provenance = from_.head_provenance;
    frame.eyes_provenance = from_.eyes_provenance;
  }
}

}  // namespace mien::shaping
