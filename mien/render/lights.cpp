#include "mien/render/lights.h"

#include <algorithm>
#include <array>

namespace mien::render {
namespace {

Look::Light light(const Vec3f& towards, const Vec3f& radiance, float radius_rad) {
  return {towards.normalized(), radiance, radius_rad};
}

/// Three lights: key from above the left, fill from the right, rim from behind.
Look studio() {
  Look look;
  look.key = light({-0.62F, 0.55F, 0.70F}, {2.55F, 2.40F, 2.25F}, 0.30F);
  look.fill = light({0.90F, 0.10F, 0.60F}, {0.62F, 0.66F, 0.72F}, 0.50F);
  look.rim = light({0.70F, 0.50F, -0.70F}, {1.25F, 1.28F, 1.34F}, 0.35F);
  look.sky = Vec3f(0.30F, 0.31F, 0.33F);
  look.ground = Vec3f(0.13F, 0.115F, 0.105F);
  look.background_top = {96, 100, 108};
  look.background_bottom = {52, 55, 61};
  return look;
}

/// An overcast sky: light from everywhere above, hardly a shadow.
Look soft() {
  Look look;
  look.key = light({-0.15F, 0.85F, 0.55F}, {1.05F, 1.08F, 1.12F}, 0.75F);
  look.fill = light({0.55F, 0.35F, 0.75F}, {0.30F, 0.31F, 0.33F}, 0.70F);
  look.rim = light({0.2F, 0.8F, -0.6F}, {0.35F, 0.36F, 0.38F}, 0.60F);
  look.sky = Vec3f(1.02F, 1.06F, 1.12F);
  look.ground = Vec3f(0.36F, 0.34F, 0.31F);
  look.background_top = {206, 212, 220};
  look.background_bottom = {178, 184, 190};
  return look;
}

/// A low sun at the side and what is left of a blue sky.
Look evening() {
  Look look;
  look.key = light({-0.88F, 0.10F, 0.42F}, {3.1F, 1.75F, 0.82F}, 0.09F);
  look.fill = light({0.75F, 0.30F, 0.60F}, {0.20F, 0.26F, 0.42F}, 0.60F);
  look.rim = light({0.60F, 0.20F, -0.78F}, {1.6F, 0.80F, 0.42F}, 0.14F);
  look.sky = Vec3f(0.17F, 0.20F, 0.30F);
  look.ground = Vec3f(0.12F, 0.085F, 0.06F);
  look.background_top = {58, 62, 92};
  look.background_bottom = {134, 84, 58};
  return look;
}

/// A ring of 850 nm diodes about the lens, as cameras that look at a face in the dark carry it. It stands
/// beside the lens, so that pupils stay dark.
Look infrared() {
  Look look;
  look.key = light({0.0F, 0.06F, 1.0F}, {2.5F, 2.5F, 2.5F}, 0.14F);
  look.sky = look.ground = Vec3f::Constant(0.05F);
  look.background_top = look.background_bottom = {10, 10, 10};
  look.infrared = true;
  return look;
}

}  // namespace

std::span<const NamedLight> named_lights() {
  static const auto all = std::to_array<NamedLight>({
      {"studio", "key, fill and rim light", studio()},
      {"soft", "an overcast sky", soft()},
      {"evening", "a low, warm sun", evening()},
      {"infrared", "a ring of 850 nm beside the camera", infrared()},
  });
  return all;
}

const NamedLight* find_light(std::string_view name) {
  const auto all = named_lights();
  const auto found = std::ranges::find(all, name, &NamedLight::name);
  return found == all.end() ? nullptr : &*found;
}

}  // namespace mien::render
