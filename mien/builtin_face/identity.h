#pragma once

#include <array>
#include <vector>

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/rotation.h"

namespace mien::builtin_face {

/// A smooth warp of space (mm, frame H) from the default head to one identity. About each eyeball it is a
/// similarity, so that eyeballs stay round and lids keep to them; what touches on the default head touches on
/// every other.
class IdentityWarp {
 public:
  explicit IdentityWarp(const BuiltinParameters& parameters);

  [[nodiscard]] Vec3 operator()(const Vec3& p) const;
  /// For points of the outer ears.
  [[nodiscard]] Vec3 ear(const Vec3& p) const;

 private:
  /// Moves what lies about `centre`, mirrored on the other side when `both`.
  struct Bump {
    Vec3 centre, inverse_radius, shift;
    bool both;
  };
  [[nodiscard]] Vec3 shift(const Vec3& p) const;

  BuiltinParameters q_;
  std::vector<Bump> bumps_;
  std::array<Vec3, 2> eye_shift_;
  double eye_scale_ = 1;
};

}  // namespace mien::builtin_face
