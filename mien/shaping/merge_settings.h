#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "mien/face/shape_region.h"

namespace mien::shaping {

/// Places with a tracker order of their own: the regions of the shapes, head pose, eye directions.
enum class MergePlace : std::uint8_t { brows, eyes, cheeks, mouth, jaw, head, gaze };
inline constexpr std::size_t kMergePlaceCount = 7;
static_assert(static_cast<std::size_t>(MergePlace::head) == face::kShapeRegionCount);
/// "brows", ..., "head", "gaze": in the order of MergePlace.
inline constexpr std::array<std::string_view, kMergePlaceCount> kMergePlaceNames = {
    "brows", "eyes", "cheeks", "mouth", "jaw", "head", "gaze"};

/// Selection among several trackers of one face (Merge).
struct MergeSettings {
  /// Priority of the modalities, by place. Those not named follow the named ones, in the session's order. At
  /// most kMostNames names of kLongestName bytes. Moving one forward: it answers wherever it is confident.
  /// Default: default_order().
  using Order = std::vector<std::string>;
  std::array<Order, kMergePlaceCount> order = default_order();
  /// Upper threshold of the hysteresis, 0 to 1: the share of a shape's variance that a tracker explains
  /// (tracker::Explained), or its confidence where nobody measured that. The first tracker in the order with
  /// at least this share takes the shape over. Raising: later trackers take a region over earlier as sensors
  /// drop out. Lowering: the first in the order keeps it with fewer sensors; 0: the order alone decides.
  float sure = 0.5F;
  /// Lower threshold, 0 to `sure`: the selected tracker keeps the shape down to this share. The difference to
  /// `sure` is also the lead that another needs where none reaches `sure`. Raising: hands over at smaller
  /// losses. Lowering: fewer changes, a failing tracker is kept longer.
  float unsure = 0.35F;
  /// Whether sound may answer. False: no shape ever has the provenance audio, and a session's microphone is
  /// closed.
  bool audio = true;

  static constexpr std::size_t kMostNames = 8;
  static constexpr std::size_t kLongestName = 32;

  /// The table of docs/reference/shaping_settings.md, which gives the reasons.
  [[nodiscard]] static std::array<Order, kMergePlaceCount> default_order();
  bool operator==(const MergeSettings&) const = default;
};

}  // namespace mien::shaping
