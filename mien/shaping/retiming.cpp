#include "mien/shaping/retiming.h"

#include <algorithm>
#include <cmath>

namespace mien::shaping {
namespace {

constexpr std::size_t kLags = 2 * Retiming::kFarthest_ms / Retiming::kStep_ms + 1;

int lag_ms(std::size_t i) {
  return static_cast<int>(i) * Retiming::kStep_ms - Retiming::kFarthest_ms;
}

}  // namespace

void Retiming::reset() {
  *this = Retiming();
}

Duration Retiming::offset() const {
  return std::chrono::round<Duration>(std::chrono::duration<double, std::milli>(offset_ms_));
}

void Retiming::push(std::optional<float> heard, std::optional<float> sensed, Duration behind) {
  const std::size_t at = next_++ % kFrames;
  known_[at] = heard && sensed;
  heard_[at] = heard.value_or(0);
  sensed_[at] = sensed.value_or(0);
  asked_ms_[at] = static_cast<float>(offset_ms_ - 1e3 * to_seconds(behind));
  if (++since_look_ >= kEvery) look();
  if (!believed_ms_) return;
  const double most_ms = kSpeed_ms_per_s / kFrameRateHz;
  offset_ms_ += std::clamp(*believed_ms_ - offset_ms_, -most_ms, behind > Duration::zero() ? 0.0 : most_ms);
}

double Retiming::correlation_at(int lag) const {
  // What is heard at t + lag belongs to what is sensed at t; between two frames heard is taken linearly.
  // Offsets change far more slowly than frames come, so the one of this frame is the other's.
  const std::size_t kept = std::min(next_, kFrames);
  const std::size_t first = next_ - kept;
  double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < kept; ++i) {
    const std::size_t at = (first + i) % kFrames;
    const double frames = (lag - double{asked_ms_[at]}) * 1e-3 * kFrameRateHz;
    const auto share = static_cast<float>(frames - std::floor(frames));
    const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(i) + static_cast<std::ptrdiff_t>(std::floor(frames));
    if (j < 0 || j + 1 >= static_cast<std::ptrdiff_t>(kept)) continue;
    const std::size_t before = (first + static_cast<std::size_t>(j)) % kFrames;
    const std::size_t after = (before + 1) % kFrames;
    if (!known_[at] || !known_[before] || !known_[after]) continue;
    const double x = double{heard_[before] + share * (heard_[after] - heard_[before])};
    const double y = double{sensed_[at]};
    ++n;
    a += x;
    b += y;
    aa += x * x;
    bb += y * y;
    ab += x * y;
  }
  const double below = (n * aa - a * a) * (n * bb - b * b);
  // Rounding alone makes a variance of a jaw that stands still.
  constexpr double kLeastVariance = 1e-6;
  if (n < static_cast<double>(kFewest) || aa / n - a / n * a / n < kLeastVariance ||
      bb / n - b / n * b / n < kLeastVariance)
    return 0;
  return (n * ab - a * b) / std::sqrt(below);
}

void Retiming::look() {
  since_look_ = 0;
  believed_ms_.reset();
  if (static_cast<std::size_t>(std::ranges::count(known_, true)) < kFewest) return;
  std::array<double, kLags> correlations{};
  for (std::size_t i = 0; i < kLags; ++i) correlations[i] = correlation_at(lag_ms(i));
  const auto best = static_cast<std::size_t>(std::ranges::max_element(correlations) - correlations.begin());
  if (correlations[best] <= kPeak) return;
  // At an end the peak may lie beyond it.
  if (best == 0 || best + 1 == kLags) return;
  for (std::size_t i = 0; i < kLags; ++i) {
    const bool peak = (i == 0 || correlations[i] >= correlations[i - 1]) &&
                      (i + 1 == kLags || correlations[i] >= correlations[i + 1]);
    if (i != best && peak && correlations[i] > correlations[best] - kLead &&
        // The top of the same hill.
        (i > best ? i - best : best - i) > 2)
      return;
  }
  believed_ms_ = lag_ms(best);
}

}  // namespace mien::shaping
