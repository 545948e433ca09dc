#include "mien/render/camera.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <system_error>

namespace mien::render {

std::optional<float> view_rad_from_name(std::string_view name) {
  if (name == "front") return kFrontView_rad;
  if (name == "three-quarter") return kThreeQuarterView_rad;
  if (name == "side") return kSideView_rad;
  float degrees = 0;
  const auto [stop, problem] = std::from_chars(name.data(), name.data() + name.size(), degrees);
  if (problem != std::errc() || stop != name.data() + name.size() || !(std::abs(degrees) <= 360))
    return std::nullopt;
  return degrees * std::numbers::pi_v<float> / 180;
}

Camera portrait_camera(const face::Face& face, float view_rad, int width, int height, float closeness) {
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
    shown_m = 2.2F * size.y();
    target.y() += 0.19F * size.y();
    // Turned, a head is about its ears, not about its face.
    target.z() -= 0.35F * size.z() * std::min(1.0F, std::abs(view_rad) / kThreeQuarterView_rad);
  }
  shown_m = std::max(shown_m, 1e-3F);

  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.target_m = target;
  // A picture narrower than high must still hold the width of the head.
  const float fit = std::max(1.0F, 0.85F * static_cast<float>(height) / static_cast<float>(width));
  // Nearer, noses grow and ears go: what is closer is seen through a longer lens, from the same place.
  const float distance_m = 4.8F * shown_m * fit;
  camera.field_of_view_rad = 2 * std::atan(0.5F * shown_m * fit / closeness / distance_m);
  camera.position_m = target + distance_m * Vec3f(std::sin(view_rad), 0.03F, std::cos(view_rad));
  return camera;
}

}  // namespace mien::render
