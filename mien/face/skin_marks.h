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

}  // namespace mien::face
