#pragma once

#include <vector>

#include "mien/core/rotation.h"

namespace mien::face {

/// A dark spot on the skin.
struct Mole {
  Vec3f centre_m = Vec3f::Zero();  ///< On the neutral face.
  float radius_m = 0;
  float darkness = 0;  ///< 0 skin's own colour to 1.
};

/// What lies on a person's skin beside its colours and is too small for them, which are given by vertex.
struct SkinMarks {
  /// Beside the face's vertices, or empty: how densely freckles (x) lie and how strongly roots of shaved hair
  /// (y) are seen, 0 to 1.
  std::vector<Eigen::Vector2f> amount;
  std::vector<Mole> moles;
  Vec3f stubble = Vec3f::Zero();  ///< Colour of those roots, linear albedo.
  float person = 0;               ///< Moves where each freckle lies; one number a person.
};

/// How a person's skin folds into lines when an expression shortens it.
struct SkinFolds {
  /// Of the folds: 1 takes all surplus skin into them; raising it deepens lines, 0 leaves skin smooth.
  float depth = 0;
  /// Surplus length at rest over length; raising it lets lines come sooner, and above 0 they stay at rest.
  /// Negative: what skin takes up elastically before it folds.
  float slack = 0;
};

}  // namespace mien::face
