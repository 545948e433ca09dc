#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
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
  /// Moves what lies about `centre`.
  struct Bump {
    Vec3 centre, inverse_radius, shift;
  };
  void add_bump(const Bump& bump);
  /// Slices of space across each axis, mm: a bit for each bump that reaches into it. The outer ones have no
  /// end.
  static constexpr std::size_t kSlices = 64, kMostBumps = 64;
  static constexpr double kSlice_mm = 5;
  [[nodiscard]] static std::size_t slice_of(double mm) {
    return static_cast<std::size_t>(std::clamp(mm / kSlice_mm + 0.5 * kSlices, 0.0, kSlices - 1.0));
  }
  [[nodiscard]] Vec3 shift(const Vec3& p) const;
  void add_bumps();
  void add_asymmetry();
  /// Of the skin about eye `e` outside of its lids' sphere: the fold of the upper lid.
  [[nodiscard]] Vec3 fold_shift(std::size_t e, const Vec3& p) const;

  BuiltinParameters q_;
  std::vector<Bump> bumps_;
  std::array<std::array<std::uint64_t, kSlices>, 3> reach_{};
  std::array<Vec3, 2> eye_shift_;
  std::array<Eigen::Matrix3d, 2> eye_turn_;  ///< Slant and size.
};

}  // namespace mien::builtin_face
