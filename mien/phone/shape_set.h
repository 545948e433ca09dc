#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "mien/face/profile_map.h"

namespace mien::phone {

/// The shape sets in which weights are told. Numbers are part of the packet and of takes: never reused.
enum class ShapeSet : std::uint8_t {
  ict53 = 0,  ///< Ours: the 53 of face::kShapeNames, then tongueOut.
  arkit52 = 1,
  openxr_fb_63 = 2,
  openxr_fb_70 = 3,
  refa_64 = 4,
  unified = 5,
};
inline constexpr std::size_t kShapeSetCount = 6;
/// Of the largest set.
inline constexpr std::size_t kMostShapes = face::kUnifiedCount;

/// None for a number that is no set's.
[[nodiscard]] std::optional<ShapeSet> shape_set(std::uint8_t number);
/// "arkit52": as `mien face profiles` has it; of our own "ict53".
[[nodiscard]] std::string_view name_of(ShapeSet set);
/// How many shapes it has, at most kMostShapes.
[[nodiscard]] std::size_t count_of(ShapeSet set);
/// Name of shape `i`, below count_of(set).
[[nodiscard]] std::string_view shape_name(ShapeSet set, std::size_t i);
/// CRC-32 of all its names in their order, each followed by a line feed: two that have one checksum mean the
/// same shapes by the same places.
[[nodiscard]] std::uint32_t names_checksum(ShapeSet set);
/// What its shapes are of ours; null for our own.
[[nodiscard]] const face::ProfileMap* map_of(ShapeSet set);

}  // namespace mien::phone
