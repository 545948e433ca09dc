#include "mien/render/camera.h"

#include <algorithm>
#include <limits>

namespace mien::render {

std::optional<View> view_from_name(std::string_view name) {
  if (name == "front") return View::front;
  if (name == "three-quarter") return View::three_quarter;
  if (name == "side") return View::side;
  return std::nullopt;
}

Camera portrait_camera(const face::Face& face, View view, int width, int height, float closeness) {
  Vec3f low = Vec3f::Constant(std::numeric_limits<float>::max());
  Vec3f high = -low;
  const auto include = [&](const Vec3f& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  };
  if (face.has_landmarks)
    for (const std::uint32_t i : face.landmarks) include(face.neutral_m[i]);
  else
    for (const Vec3f& p : face.neutral_m) include(p);

  // Landmarks reach from chin to brows: some 60 % of a head's height, the rest lies above.
  const Vec3f size = high - low;
  float shown_m = 1.15F * size.y();
  Vec3f target = 0.5F * (low + high);
  if (face.has_landmarks) {
    shown_m = 2.05F * size.y();
    target.y() += 0.14F * size.y();
    if (view != View::front) target.z() -= 0.35F * size.z();
  }
  shown_m = std::max(shown_m, 1e-3F) / closeness;

  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.target_m = target;
  camera.field_of_view_rad = 0.32F;
  const float yaw_rad = view == View::front ? 0.0F : view == View::three_quarter ? 0.68F : 1.5F;
  // A picture narrower than high must still hold the width of the head.
  const float fit = std::max(1.0F, 0.85F * static_cast<float>(height) / static_cast<float>(width));
  const float distance_m = 0.5F * shown_m * fit / std::tan(0.5F * camera.field_of_view_rad);
  camera.position_m = target + distance_m * Vec3f(std::sin(yaw_rad), 0.03F, std::cos(yaw_rad));
  return camera;
}

}  // namespace mien::render
