#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/face/profile.h"
#include "mien/face/profile_names.h"

namespace mien::face {

/// What a profile of the outside world can be told of a face: the 53, and tongueOut at kShapeCount.
inline constexpr std::size_t kInnerCount = kShapeCount + 1;
/// Index of an inner shape by name, tongueOut among them; kInnerCount when there is none.
[[nodiscard]] constexpr std::size_t inner_index(std::string_view name) {
  if (name == "tongueOut") return kShapeCount;
  const std::size_t i = shape_index(name);
  return i == kShapeCount ? kInnerCount : i;
}
[[nodiscard]] constexpr std::string_view inner_name(std::size_t i) {
  return i < kShapeCount ? kShapeNames[i] : "tongueOut";
}

/// One number of a sparse matrix: its column and its value, finite.
struct ProfileTerm {
  std::uint16_t column = 0;
  float factor = 0;
};

/// A sparse matrix by rows: of row r the terms from first[r] up to first[r + 1], by ascending column.
struct SparseRows {
  std::span<const std::uint16_t> first;  ///< One more than there are rows.
  std::span<const ProfileTerm> terms;

  [[nodiscard]] std::size_t size() const noexcept { return first.size() - 1; }
  [[nodiscard]] std::span<const ProfileTerm> operator[](std::size_t row) const noexcept {
    return terms.subspan(first[row], static_cast<std::size_t>(first[row + 1] - first[row]));
  }
};

/// A shape without a counterpart, and why it has none.
struct Unmatched {
  std::uint16_t shape = 0;
  std::string_view reason;
};

/// A profile of the outside world beside the inner one: what each of its shapes is of ours and back, compiled
/// from profiles/NAME.toml (docs/reference/profiles.md). All of it lives as long as the program.
struct ProfileMap {
  std::string_view name;    ///< "openxr_fb_70"
  std::string_view title;   ///< "OpenXR XR_FB_face_tracking2"
  std::string_view source;  ///< Who publishes it, and who says what is what.
  std::span<const std::string_view> shapes;
  std::span<const ShapeGroup> groups;  ///< They follow each other and hold all shapes; or none.
  std::span<const Unmatched> without;  ///< Of `shapes`: those with no counterpart inside.
  std::span<const Unmatched> lacks;    ///< Of the inner ones: those that the profile cannot tell.
  SparseRows outward;                  ///< A row a shape of the profile, a column an inner one.
  SparseRows inward;                   ///< A row an inner shape, a column one of the profile.

  /// The profile's weights in its order, of weights 0 to 1 or a little beyond; what has no counterpart is 0.
  /// Writes as many as both `out` and the profile have. mouthClose is not held to jawOpen. No allocation,
  /// thread-safe.
  void from_ict(const BlendshapeWeights& ict, float tongue_out, std::span<float> out) const noexcept;
  /// The way back; inner shapes that the profile cannot tell are 0, weights beyond the end of `weights` count
  /// as 0. No allocation, thread-safe.
  [[nodiscard]] BlendshapeWeights to_ict(std::span<const float> weights,
                                         float* tongue_out = nullptr) const noexcept;

  /// The group of a shape; empty where the profile has none.
  [[nodiscard]] std::string_view group_of(std::size_t shape) const noexcept;
  /// Shapes that are the mean of several inner ones (ARKit's browInnerUp): the way back gives these the same.
  [[nodiscard]] std::size_t merged_count() const noexcept;
  /// Inner shapes that several of the profile's are made of (mouthFunnel of four).
  [[nodiscard]] std::size_t divided_count() const noexcept;
};

/// In the order of OutsideProfile.
[[nodiscard]] std::span<const ProfileMap> profile_maps() noexcept;
[[nodiscard]] const ProfileMap& profile_map(OutsideProfile profile) noexcept;
/// By its name. Errors: not_found, with the nearest name.
[[nodiscard]] Result<const ProfileMap*> find_profile_map(const std::string& name);

}  // namespace mien::face
