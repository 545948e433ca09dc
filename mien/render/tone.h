#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "mien/core/rotation.h"
#include "mien/render/image.h"

namespace mien::render {

/// From a to b as t goes from 0 to 1.
[[nodiscard]] inline Vec3f mix(const Vec3f& a, const Vec3f& b, float t) {
  return a + t * (b - a);
}

/// Linear 0 to 1 to sRGB's curve (IEC 61966-2-1).
[[nodiscard]] inline float srgb_curve(float linear) {
  return linear <= 0.0031308F ? 12.92F * linear : 1.055F * std::pow(linear, 1 / 2.4F) - 0.055F;
}
[[nodiscard]] inline float linear_from_srgb(float s) {
  return s <= 0.04045F ? s / 12.92F : std::pow((s + 0.055F) / 1.055F, 2.4F);
}
[[nodiscard]] inline Rgb to_srgb(const Vec3f& linear) {
  Rgb out{};
  for (int c = 0; c < 3; ++c)
    out[static_cast<std::size_t>(c)] =
        static_cast<std::uint8_t>(255 * srgb_curve(std::clamp(linear[c], 0.0F, 1.0F)) + 0.5F);
  return out;
}
[[nodiscard]] inline Vec3f from_srgb(Rgb colour) {
  return {linear_from_srgb(colour[0] / 255.0F), linear_from_srgb(colour[1] / 255.0F),
          linear_from_srgb(colour[2] / 255.0F)};
}

/// Scene light to what a picture can show: near to the identity up to 0.5, then a shoulder that reaches 1 at
/// infinity, so that highlights roll off instead of clipping. A channel at a time, with some bleeding to
/// white.
[[nodiscard]] inline Vec3f tone_map(const Vec3f& light) {
  const auto shoulder = [](float x) {
    constexpr float kKnee = 0.45F;
    if (x <= kKnee) return std::max(x, 0.0F);
    const float over = (x - kKnee) / (1 - kKnee);
    return kKnee + (1 - kKnee) * over / (1 + over);
  };
  const float brightest = light.maxCoeff();
  const float bleed = 0.06F * std::max(0.0F, brightest - 0.7F);
  const Vec3f bled = light + bleed * (Vec3f::Constant(brightest) - light);
  return {shoulder(bled[0]), shoulder(bled[1]), shoulder(bled[2])};
}

}  // namespace mien::render
