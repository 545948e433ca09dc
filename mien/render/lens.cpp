#include "mien/render/lens.h"

#include <algorithm>
#include <cmath>

namespace mien::render {
namespace {

constexpr float kClosest_m = 1e-3F;
/// Tangents beyond which nothing is drawn: 80 degrees off the axis.
constexpr float kWidest = 5.7F;
/// Subpixels: added while rounding, since what is cut off rounds towards 0; so far off the picture's corner a
/// place is drawn at most.
constexpr float kOffset = 1 << 17;

/// The tangent up to which the picture grows with the angle.
float rim(float k1) {
  return k1 < 0 ? std::min(kWidest, std::sqrt(-1 / (3 * k1))) : kWidest;
}

}  // namespace

ScreenPoint Lens::project(const Vec3f& p_m) const {
  ScreenPoint point;
  project({&p_m.x(), 1}, {&p_m.y(), 1}, {&p_m.z(), 1}, {&point, 1});
  return point;
}

void Lens::project(std::span<const float> x_m, std::span<const float> y_m, std::span<const float> z_m,
                   std::span<ScreenPoint> out) const {
  const float most = rim(k1), most2 = most * most, scale = kSubpixels / pixel;
  const float left = kSubpixels * centre_px.x() + kOffset, top = kSubpixels * centre_px.y() + kOffset;
  const Vec3f at = position_m, ahead = forward, side = right, above = up;
  const float bend = k1;
  // Without branches, so that compilers make vectors of it.
  for (std::size_t i = 0; i < out.size(); ++i) {
    const float dx = x_m[i] - at.x(), dy = y_m[i] - at.y(), dz = z_m[i] - at.z();
    const float depth_m = dx * ahead.x() + dy * ahead.y() + dz * ahead.z();
    const float inverse = 1 / std::max(depth_m, kClosest_m);
    const float x = inverse * (dx * side.x() + dy * side.y() + dz * side.z());
    const float y = inverse * (dx * above.x() + dy * above.y() + dz * above.z());
    const float r2 = x * x + y * y;
    const bool seen = depth_m > kClosest_m && r2 < most2;
    const float bent = scale * (1 + bend * std::min(r2, most2));
    const float across = std::clamp(left + bent * x, 0.0F, 2 * kOffset);
    const float down = std::clamp(top - bent * y, 0.0F, 2 * kOffset);
    // (No number becomes a whole one that is no number.)
    out[i].x =
        static_cast<std::int32_t>((seen ? across : kOffset) + 0.5F) - static_cast<std::int32_t>(kOffset);
    out[i].y = static_cast<std::int32_t>((seen ? down : kOffset) + 0.5F) - static_cast<std::int32_t>(kOffset);
    out[i].inverse_depth = seen ? inverse : 0.0F;
  }
}

Vec3f Lens::ray(float x, float y) const {
  const Eigen::Vector2f shown = pixel * (Eigen::Vector2f(x, y) - centre_px);
  const float most = rim(k1), wanted = std::min(shown.norm(), most * (1 + k1 * most * most));
  float r = wanted;
  for (int i = 0; i < 6; ++i) {  // Newton; the slope is above 0 inside the rim.
    const float slope = 1 + 3 * k1 * r * r;
    r = std::clamp(r - (r * (1 + k1 * r * r) - wanted) / std::max(slope, 0.05F), 0.0F, most);
  }
  const float scale = wanted > 0 ? r / std::max(shown.norm(), 1e-9F) : 1.0F;
  return (forward + scale * (shown.x() * right - shown.y() * up)).normalized();
}

Lens make_lens(const Vec3f& position_m, const Vec3f& look_at_m, const Vec3f& up, float field_of_view_rad,
               float k1, int width, int height) {
  Lens lens;
  lens.width = width;
  lens.height = height;
  lens.position_m = position_m;
  lens.forward = (look_at_m - position_m).normalized();
  lens.right = lens.forward.cross(up).normalized();
  lens.up = lens.right.cross(lens.forward);
  lens.pixel = 2 * std::tan(0.5F * field_of_view_rad) / static_cast<float>(std::max(width, height));
  lens.k1 = k1;
  lens.centre_px = 0.5F * Eigen::Vector2f(static_cast<float>(width), static_cast<float>(height));
  return lens;
}

}  // namespace mien::render
