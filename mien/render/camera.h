#pragma once

#include <optional>
#include <string_view>

#include "mien/core/rotation.h"
#include "mien/face/face.h"

namespace mien::render {

/// Where a picture is taken from, frame H.
struct Camera {
  int width = 640;   ///< Pixels.
  int height = 640;  ///< Pixels.
  Vec3f position_m = Vec3f(0, 0, 1);
  Vec3f target_m = Vec3f::Zero();   ///< In the middle of the picture.
  Vec3f up = Vec3f::UnitY();        ///< Not along the line of sight.
  float field_of_view_rad = 0.35F;  ///< Vertical, whole angle.
  bool operator==(const Camera&) const = default;
};

/// From where a face is looked at: radians about the vertical, 0 from the front, positive from the
/// performer's left.
inline constexpr float kFrontView_rad = 0, kThreeQuarterView_rad = 0.68F, kSideView_rad = 1.5F;

/// "front", "three-quarter", "side", or degrees between -360 and 360: "45".
[[nodiscard]] std::optional<float> view_rad_from_name(std::string_view name);

/// A camera that has the whole neutral face in the picture, as a portrait photographer would: from about 1.4
/// metres with a long lens. `closeness` 1 shows the head, 2 half of that through a longer one.
[[nodiscard]] Camera portrait_camera(const face::Face& face, float view_rad, int width, int height,
                                     float closeness = 1);

}  // namespace mien::render
