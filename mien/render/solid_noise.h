#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "mien/core/rotation.h"

namespace mien::render {

/// Smooth noise in space, the same everywhere and always: about -1 to 1, one bump a unit of length.
/// Source: Perlin 2002, "Improving noise", doi:10.1145/566654.566636; our own hash for its table.
[[nodiscard]] inline float solid_noise(const Vec3f& p) {
  const Vec3f base = p.array().floor();
  const Vec3f f = p - base;
  const Vec3f s = f.array() * f.array() * f.array() * (f.array() * (f.array() * 6.0F - 15.0F) + 10.0F);
  const auto x0 = static_cast<std::int32_t>(base.x());
  const auto y0 = static_cast<std::int32_t>(base.y());
  const auto z0 = static_cast<std::int32_t>(base.z());
  const auto corner = [&](int dx, int dy, int dz) {
    std::uint32_t h = static_cast<std::uint32_t>(x0 + dx) * 0x8DA6B343U ^
                      static_cast<std::uint32_t>(y0 + dy) * 0xD8163841U ^
                      static_cast<std::uint32_t>(z0 + dz) * 0xCB1AB31FU;
    h = (h ^ (h >> 15U)) * 0x2C1B3C6DU;
    h ^= h >> 13U;
    // Three signed 10-bit numbers make the gradient.
    const auto part = [h](unsigned shift) {
      return static_cast<float>(static_cast<int>(h >> shift & 1023U) - 512) / 512.0F;
    };
    return part(0) * (f.x() - static_cast<float>(dx)) + part(10) * (f.y() - static_cast<float>(dy)) +
           part(20) * (f.z() - static_cast<float>(dz));
  };
  const auto mix = [](float a, float b, float t) { return a + t * (b - a); };
  return mix(
      mix(mix(corner(0, 0, 0), corner(1, 0, 0), s.x()), mix(corner(0, 1, 0), corner(1, 1, 0), s.x()), s.y()),
      mix(mix(corner(0, 0, 1), corner(1, 0, 1), s.x()), mix(corner(0, 1, 1), corner(1, 1, 1), s.x()), s.y()),
      s.z());
}

/// Three such noises at once, from a table: several times as fast as one of the above. They repeat every 8
/// units.
[[nodiscard]] Vec3f solid_noises(const Vec3f& p);

}  // namespace mien::render
