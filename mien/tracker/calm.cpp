#include "mien/tracker/calm.h"

#include <algorithm>

#include "mien/core/time.h"

namespace mien::tracker {
namespace {

const std::array kLids = {face::shape("eyeBlink_L"), face::shape("eyeBlink_R")};

}  // namespace

void Calm::apply(face::BlendshapeWeights& weights) {
  const bool first = frames_ == 0;
  const DeviceTime now = DeviceTime{} + frame_offset(frames_++);
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const auto one = static_cast<float>(filters_[k].filter(now, weights[k]));
    if (std::ranges::find(kLids, k) != kLids.end()) {
      const float speed = first ? 0 : (one - last_[k]) * static_cast<float>(kFrameRateHz);
      last_[k] = one;
      const float lead = kBlinkLead * std::max(0.0F, speed - kBlinkSpeed);
      weights[k] = lead > 0 ? std::max(one, std::min(1.0F, one + lead)) : one;
    } else {
      last_[k] = first ? one : last_[k] + kFollow * (one - last_[k]);
      weights[k] = last_[k];
    }
  }
}

}  // namespace mien::tracker
