#pragma once

#include <algorithm>

namespace mien::shaping {

/// Times of the fallback and of changes between trackers (Fallback, Merge). Effects: docs/method/shaping.md.
struct FallbackSettings {
  /// How long the last frame is held after the loss of all sensors, s, 0 to 10. Raising: longer gaps are
  /// bridged, the avatar stares longer. Lowering: short gaps already ease to neutral.
  double hold_s = 0.3;
  /// Duration of the following ease to neutral, s, kShortest_s to 10. Raising: a slower, smaller step per
  /// frame. Lowering: neutral sooner, larger steps.
  double neutral_s = 0.5;
  /// Time to 95 % of the way from what is shown to the tracker's face, when sensors come back, their number
  /// changes or another tracker answers, s, kShortest_s to 10. Raising: smoother, accurate later. Lowering:
  /// accurate sooner, larger steps (0.03 s / return_s of the offset per 60 Hz frame).
  double return_s = 0.3;
  static constexpr double kShortest_s = 0.05;
  static constexpr double kLongest_s = 10;

  /// The settings with times clamped to their ranges; NaN becomes the least.
  [[nodiscard]] FallbackSettings within_range() const;
  bool operator==(const FallbackSettings&) const = default;
};

inline FallbackSettings FallbackSettings::within_range() const {
  const auto within = [](double x, double least) {
    return x > least ? std::min(x, kLongest_s) : least;  // NaN: the least.
  };
  return {within(hold_s, 0), within(neutral_s, kShortest_s), within(return_s, kShortest_s)};
}

}  // namespace mien::shaping
