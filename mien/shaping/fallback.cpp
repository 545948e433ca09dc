#include "mien/shaping/fallback.h"

#include <algorithm>
#include <cmath>

#include "mien/shaping/bounds.h"
#include "mien/shaping/ease.h"

namespace mien::shaping {
namespace {

using face::Provenance;

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
    letting_go_.stop();
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
  const bool back = phase_ == Phase::lost;
  if (back) from_ = shown_;
  if (back || (phase_ == Phase::following && sensors_there != sensors_there_)) {
    if (!letting_go_.going()) returning_ = back;
    since_ = shown_.time;
    letting_go_.take_all(shown_, frame);
  }
  phase_ = Phase::following;
  sensors_there_ = sensors_there;
  letting_go_.apply(frame, to_seconds(frame.time - shown_.time), settings_.return_s);
  if (returning_ && letting_go_.going()) tell_of_return(frame);
}

void Fallback::tell_of_return(face::OutputFrame& frame) const {
  // Confidence comes with the tracker's share of what is shown, provenance with its larger half.
  const double omega = kConstantsTo5Percent / settings_.return_s;
  const double age_s = to_seconds(frame.time - since_);
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
