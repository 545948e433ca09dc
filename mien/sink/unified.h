#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "mien/face/profile_names.h"
#include "mien/sink/arkit_frame.h"

namespace mien::sink {

using face::kUnifiedCount;
using face::kUnifiedNames;

/// A face in the terms of Unified Expressions, by face's table (profiles/unified.toml). What ARKit does not
/// know (cheeks sucked in, tightened lips, where the tongue points, nostrils, neck) stays 0.
struct UnifiedFrame {
  std::array<float, kUnifiedCount> shapes{};  ///< 0 to 1.
  std::array<float, 2> openness = {1, 1};     ///< Left eye, right eye: 1 open, 0 closed.
  /// tan(yaw) to the performer's right and tan(pitch) upwards, within +-1 (45 degrees); left eye, right eye.
  std::array<std::array<float, 2>, 2> gaze{};
};
[[nodiscard]] UnifiedFrame unified_frame(const ArkitFrame& frame);

/// A parameter of VRCFaceTracking's second set: `v2/NAME`, -1 to 1 or 0 to 1.
struct UnifiedParameter {
  std::string_view name;
  float (*value)(const UnifiedFrame&) = nullptr;  ///< Null: the base shape of that index.
  std::size_t shape = 0;

  [[nodiscard]] float of(const UnifiedFrame& frame) const {
    return value == nullptr ? frame.shapes[shape] : value(frame);
  }
};
/// The 88 base shapes, then what is derived from them and from the eyes. No name ends in a digit.
[[nodiscard]] std::span<const UnifiedParameter> unified_parameters();

}  // namespace mien::sink
