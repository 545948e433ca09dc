#include "mien/tracker/jitter_filter.h"

#include <algorithm>

#include "mien/core/time.h"

namespace mien::tracker {
namespace {

const std::array kLids = {face::shape("eyeBlink_L"), face::shape("eyeBlink_R")};

}  // namespace

void JitterFilter::apply(face::BlendshapeWeights& weights) {
  const bool first = frames_ == 0;
  const DeviceTime now = DeviceTime{} + frame_offset(frames_++);
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const auto one = static_cast<float>(filters_[k].filter(now, weights[k]));
    const bool lid = std::ranges::find(kLids, k) != kLids.end();
    const float next = first || lid ? one : last_[k] + kLowPassGain * (one - last_[k]);
    const float speed = first ? 0 : (next - last_[k]) * static_cast<float>(kFrameRateHz);
    last_[k] = next;
    if (lid) {
      const float lead = kBlinkLead * std::max(0.0F, speed - kBlinkThreshold);
      weights[k] = lead > 0 ? std::max(next, std::min(1.0F, next + lead)) : next;
    } else {
      speed_[k] += kSpeedGain * (speed - speed_[k]);
      weights[k] = std::clamp(next + kLead * speed_[k], 0.0F, 1.0F);
    }
  }
}

}  // namespace mien::tracker
