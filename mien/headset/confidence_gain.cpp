#include "mien/headset/confidence_gain.h"

#include <algorithm>
#include <cmath>

#include "mien/core/logistic.h"

namespace mien::headset {
namespace {

/// Confidences nearer to 0 and 1 are taken for this one.
constexpr float kSurest = 1e-4F;
/// What a gain grows by is never less than that of this one.
constexpr float kLeastGrowing = 0.1F;

bool passes(face::ShapeRegion region) {
  return region == face::ShapeRegion::brows || region == face::ShapeRegion::eyes;
}

}  // namespace

void ConfidenceGain::apply(const Confidence& confidence, Answer& answer) {
  Last now;
  for (std::size_t r = 0; r < confidence.size(); ++r) {
    const float held = std::clamp(confidence[r], kSurest, 1 - kSurest);
    now.log_odds[r] = std::log(held / (1 - held));
    now.gain[r] = 1;
    if (!last_ || passes(static_cast<face::ShapeRegion>(r))) continue;
    const float falls = std::min(0.0F, now.log_odds[r] - last_->log_odds[r]);
    const float ahead = logistic(now.log_odds[r] + settings_.lead_frames * falls);
    const float ramp = (ahead - settings_.unsure) / (settings_.sure - settings_.unsure);
    const float most = last_->gain[r] + settings_.growth * std::max(last_->gain[r], kLeastGrowing);
    now.gain[r] = std::min(std::lerp(settings_.least, 1.0F, std::clamp(ramp, 0.0F, 1.0F)), most);
  }
  if (last_) {
    const auto gain_of = [&](face::ShapeRegion region) { return now.gain[static_cast<std::size_t>(region)]; };
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      answer.weights[k] = std::lerp(last_->weights[k], answer.weights[k], gain_of(face::kShapeRegions[k]));
    answer.tongue_out = std::lerp(last_->tongue_out, answer.tongue_out, gain_of(face::ShapeRegion::jaw));
  }
  now.weights = answer.weights;
  now.tongue_out = answer.tongue_out;
  last_ = now;
}

}  // namespace mien::headset
