#pragma once

#include <algorithm>

namespace mien::shaping {

/// How long what is lost stays, and how fast it comes back.
struct FallbackSettings {
  /// s, 0 to 10: how long the last frame is held when all sensors are lost. Raising bridges longer gaps and
  /// leaves the avatar staring longer.
  double hold_s = 0.3;
  /// s, 0.05 to 10: how long it then takes to neutral.
  double neutral_s = 0.5;
  /// s, 0.05 to 10: in which 95 % of the way from what is shown to the tracker's face is gone when sensors
  /// come back or change. Raising is smoother and truer later.
  double return_s = 0.3;
  static constexpr double kShortest_s = 0.05;
  static constexpr double kLongest_s = 10;

  /// Times out of range brought into it.
  [[nodiscard]] FallbackSettings within_range() const;
  bool operator==(const FallbackSettings&) const = default;
};

inline FallbackSettings FallbackSettings::within_range() const {
  const auto within = [](double x, double least) {
    return x > least ? std::min(x, kLongest_s) : least;  // Not a number: the least.
  };
  return {within(hold_s, 0), within(neutral_s, kShortest_s), within(return_s, kShortest_s)};
}

}  // namespace mien::shaping
