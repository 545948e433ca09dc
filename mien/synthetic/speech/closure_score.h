#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mien/synthetic/speech/spoken_passage.h"

namespace mien::synthetic {

/// How well closures of the lips were heard.
struct ClosureScore {
  std::size_t truths = 0, heard = 0;  ///< Closures there were, and closures that were told.
  std::size_t found = 0;              ///< Of both: those that belong together.

  [[nodiscard]] double recall() const {
    return truths == 0 ? 1 : static_cast<double>(found) / static_cast<double>(truths);
  }
  /// Share of what was told that is none.
  [[nodiscard]] double false_share() const {
    return heard == 0 ? 0 : 1 - static_cast<double>(found) / static_cast<double>(heard);
  }
  void add(const ClosureScore& other) {
    truths += other.truths;
    heard += other.heard;
    found += other.found;
  }
};

/// How far what is heard may lie beside the truth.
inline constexpr double kClosureTolerance_s = 0.05;

/// One closure heard belongs to one true one at most: they belong together where one begins no later than the
/// tolerance after the other ends. Both in order of time. A mouth that is always closed finds one.
[[nodiscard]] ClosureScore score_closures(std::span<const Closure> truth, std::span<const Closure> heard,
                                          double tolerance_s = kClosureTolerance_s);

/// Stretches in which a track, a value each `step_s` from `first_s` on, is at least `threshold`.
[[nodiscard]] std::vector<Closure> stretches_above(std::span<const float> track, float threshold,
                                                   double first_s, double step_s);

}  // namespace mien::synthetic
