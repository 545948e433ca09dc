#pragma once

#include <array>
#include <vector>

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/rotation.h"

namespace mien::builtin_face {

/// The numbers held to what people have, each leaning as age and sex say. What the warp and the lids go by.
[[nodiscard]] BuiltinParameters leaning(const BuiltinParameters& parameters);

/// A smooth warp of space (mm, frame H) from the default head to one identity. About each eyeball it is a
/// similarity, so that eyeballs stay round and lids keep to them; what touches on the default head touches on
/// every other.
class IdentityWarp {
 public:
  explicit IdentityWarp(const BuiltinParameters& parameters);

  [[nodiscard]] Vec3 operator()(const Vec3& p) const;
  /// For points of the outer ears.
  [[nodiscard]] Vec3 ear(const Vec3& p) const;
  /// What it goes by: leaning(parameters).
  [[nodiscard]] const BuiltinParameters& numbers() const { return q_; }

 private:
  /// Moves what lies about `centre`, mirrored on the other side when `both`.
  struct Bump {
    Vec3 centre, inverse_radius, shift;
    bool both;
  };
  [[nodiscard]] Vec3 shift(const Vec3& p) const;
  void add_bumps();
  void add_asymmetry();
  /// Of the skin about eye `e` outside of its lids' sphere: the fold of the upper lid.
  [[nodiscard]] Vec3 fold_shift(std::size_t e, const Vec3& p) const;

  BuiltinParameters q_;
  std::vector<Bump> bumps_;
  std::array<Vec3, 2> eye_shift_;
  std::array<Eigen::Matrix3d, 2> eye_turn_;  ///< Slant and size.
};

}  // namespace mien::builtin_face
