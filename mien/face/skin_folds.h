#pragma once

namespace mien::face {

/// How a person's skin folds into lines when an expression shortens it.
struct SkinFolds {
  /// Of the folds: 1 takes all surplus skin into them; raising it deepens lines, 0 leaves skin smooth.
  float depth = 0;
  /// Surplus length at rest over length; raising it lets lines come sooner, and above 0 they stay at rest.
  /// Negative: what skin takes up elastically before it folds.
  float slack = 0;
};

}  // namespace mien::face
