#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "mien/face/profile.h"

namespace mien::face {

/// Where on the face a shape of the inner profile acts.
enum class ShapeRegion : std::uint8_t {
  brows,
  eyes,    ///< Lids, and where the eyes look.
  cheeks,  ///< With the nose: what raises the cheeks wrinkles it.
  mouth,
  jaw,
};
inline constexpr std::size_t kShapeRegionCount = 5;
/// As files and messages name them, in that order.
inline constexpr std::array<std::string_view, kShapeRegionCount> kShapeRegionNames = {
    "brows", "eyes", "cheeks", "mouth", "jaw"};

namespace detail {
/// ICT's names begin with the region.
consteval ShapeRegion region_by_name(std::string_view shape) {
  if (shape.starts_with("brow")) return ShapeRegion::brows;
  if (shape.starts_with("eye")) return ShapeRegion::eyes;
  if (shape.starts_with("cheek") || shape.starts_with("nose")) return ShapeRegion::cheeks;
  if (shape.starts_with("mouth")) return ShapeRegion::mouth;
  if (shape.starts_with("jaw")) return ShapeRegion::jaw;
  throw "a shape of no region";
}

consteval std::array<ShapeRegion, kShapeCount> regions_by_name() {
  std::array<ShapeRegion, kShapeCount> regions{};
  for (std::size_t i = 0; i < kShapeCount; ++i) regions[i] = region_by_name(kShapeNames[i]);
  return regions;
}
}  // namespace detail

/// The region of each of the 53, by number: brows 6, eyes 14, cheeks 6, mouth 23, jaw 4.
inline constexpr std::array<ShapeRegion, kShapeCount> kShapeRegions = detail::regions_by_name();

}  // namespace mien::face
