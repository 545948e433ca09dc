#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "mien/face/shape_region.h"

namespace mien::shaping {

/// What trackers are asked about apart from each other: the regions of the shapes, the head's pose and the
/// eyes' directions.
enum class MergePlace : std::uint8_t { brows, eyes, cheeks, mouth, jaw, head, gaze };
inline constexpr std::size_t kMergePlaceCount = 7;
static_assert(static_cast<std::size_t>(MergePlace::head) == face::kShapeRegionCount);
/// "brows", ..., "head", "gaze": in the order of MergePlace.
inline constexpr std::array<std::string_view, kMergePlaceCount> kMergePlaceNames = {
    "brows", "eyes", "cheeks", "mouth", "jaw", "head", "gaze"};

/// Who answers where, when several trackers watch one face.
struct MergeSettings {
  /// Modalities in the order in which they are asked, a place. One that is not named is asked after those
  /// that are, in the session's own order.
  using Order = std::vector<std::string>;
  std::array<Order, kMergePlaceCount> order = default_order();
  /// 0 to 1: the first in the order that is at least so confident of a shape takes it over. Raising hands a
  /// region on earlier when sensors fall off.
  float sure = 0.5F;
  /// 0 to `sure`: and keeps it until it is less confident than this. Lowering, against `sure`, lets a
  /// confidence swing further before the answer changes hands.
  float unsure = 0.35F;

  static constexpr std::size_t kMostNames = 8;
  static constexpr std::size_t kLongestName = 32;

  /// docs/reference/shaping_settings.md gives the table and its reasons.
  [[nodiscard]] static std::array<Order, kMergePlaceCount> default_order();
  bool operator==(const MergeSettings&) const = default;
};

}  // namespace mien::shaping
