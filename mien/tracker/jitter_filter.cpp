#include "mien/tracker/jitter_filter.h"

#include <algorithm>
#include <cmath>

#include "mien/core/time.h"

namespace mien::tracker {
namespace {

constexpr std::array kLids = {face::shape("eyeBlink_L"), face::shape("eyeBlink_R")};

/// A level below this is as good as none: where it went on falling while a face hardly moves, noise that is
/// back would be believed seconds later only.
constexpr float kLeastNoise = 2e-4F;

bool is_lid(std::size_t shape) {
  return std::ranges::find(kLids, shape) != kLids.end();
}

}  // namespace

float NoiseLevel::add(const face::BlendshapeWeights& answer) {
  if (frames_ == 3) {
    float sum = 0;
    int moving = 0;
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      const float difference = std::abs(answer[k] - 3 * last_[0][k] + 3 * last_[1][k] - last_[2][k]);
      sum += difference;
      if (difference > 0) ++moving;
    }
    if (moving > 0 && std::isfinite(sum))
      level_ =
          std::max(kLeastNoise,
                   level_ + gain_ * (std::min(sum / static_cast<float>(moving), kOutlier * level_) - level_));
  } else {
    ++frames_;
  }
  last_[2] = last_[1];
  last_[1] = last_[0];
  last_[0] = answer;
  return level_;
}

JitterFilter::JitterFilter(const JitterSettings& settings)
    : settings_(settings), noise_(settings.reference_noise, settings.noise_gain) {
  for (const std::size_t lid : kLids) filters_[lid].set(kLidSettings);
}

void JitterFilter::apply(face::BlendshapeWeights& weights) {
  const bool first = frames_ == 0;
  const DeviceTime now = DeviceTime{} + frame_offset(frames_++);
  const float wider = std::clamp(settings_.reference_noise / noise_.add(weights), kNarrowest, kWidest);
  const OneEuroSettings one_euro{.min_cutoff_hz = settings_.cutoff_hz * wider,
                                 .beta = settings_.beta,
                                 .derivative_cutoff_hz = settings_.speed_cutoff_hz};
  const auto share = static_cast<float>(
      low_pass_share(settings_.low_pass_hz * wider, 1.0 / static_cast<double>(kFrameRateHz)));
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const bool lid = is_lid(k);
    if (!lid) filters_[k].set(one_euro);
    const auto one = static_cast<float>(filters_[k].filter(now, weights[k]));
    const float next = first || lid ? one : last_[k] + share * (one - last_[k]);
    const float speed = first ? 0 : (next - last_[k]) * static_cast<float>(kFrameRateHz);
    last_[k] = next;
    const float lead = lid ? kBlinkLead * std::max(0.0F, speed - kBlinkThreshold) : 0;
    weights[k] = lead > 0 ? std::max(next, std::min(1.0F, next + lead)) : next;
  }
}

}  // namespace mien::tracker
