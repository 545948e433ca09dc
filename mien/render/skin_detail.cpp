#include "mien/render/skin_detail.h"

#include <algorithm>
#include <cstdint>

#include "mien/core/smoothstep.h"
#include "mien/render/solid_noise.h"

namespace mien::render {
namespace {

/// How much of bumps that stand `per_m` beside each other such a pixel still shows, 0 to 1.
float seen(float per_m, float footprint_m) {
  return 1 - smoothstep(0.4F / per_m, 1.0F / per_m, footprint_m);
}

/// Space in cubes, with one dot in each: where p is in its cube, and what the dot is like.
struct Cell {
  Vec3f from_dot;                // To p, metres.
  float chance, size, strength;  // 0 to 1, each drawn anew.
};

/// The dot keeps away from its cube's sides by a quarter of `side_m`: a smaller one lies in no other cube.
Cell cell_at(const Vec3f& p, float side_m) {
  const Vec3f scaled = p / side_m;
  const Vec3f base = scaled.array().floor();
  std::uint32_t h = 0x2545F491U;
  for (int c = 0; c < 3; ++c) {
    h = (h ^ static_cast<std::uint32_t>(static_cast<std::int32_t>(base[c]))) * 0x9E3779B1U;
    h ^= h >> 15U;
  }
  const auto draw = [&h] {
    h = (h ^ (h >> 16U)) * 0x85EBCA6BU;
    h = (h ^ (h >> 13U)) * 0xC2B2AE35U;
    return static_cast<float>((h ^ h >> 16U) >> 8U) / 16777216.0F;
  };
  Vec3f dot;
  for (int c = 0; c < 3; ++c) dot[c] = 0.25F + 0.5F * draw();
  Cell cell;
  cell.from_dot = (scaled - base - dot) * side_m;
  cell.chance = draw();
  cell.size = draw();
  cell.strength = draw();
  return cell;
}

/// What a cut through soft balls of radius 1, one in each cube of side 1, covers on average.
constexpr float kSoftBall = 2.0484F;

/// A soft dot; one smaller than a pixel pales instead of vanishing, as far as it stays in its cube.
float dot_cover(float distance_m, float radius_m, float footprint_m, float side_m) {
  const float wide = std::clamp(0.6F * footprint_m, radius_m, std::max(radius_m, 0.25F * side_m));
  const float paler = radius_m / wide;
  return paler * paler * paler * (1 - smoothstep(0.55F * wide, wide, distance_m));
}

/// The dots of a layer, or where a pixel shows several of its cubes their mean.
float averaged(float cover, float mean, float footprint_m, float side_m) {
  return cover + (mean - cover) * smoothstep(0.4F * side_m, 0.9F * side_m, footprint_m);
}

/// Cubes of several people do not coincide.
Vec3f moved(const Vec3f& p, float person) {
  return p + person * Vec3f(0.00137F, 0.00071F, 0.00219F);
}

}  // namespace

Vec3f with_pores(const Vec3f& normal, const Vec3f& neutral_m, float bump, float footprint_m) {
  Vec3f out = normal;
  const auto tilt = [&](float per_m, float strength) {
    const float share = bump * seen(per_m, footprint_m);
    if (share > 0) out += strength * share * solid_noises(neutral_m * per_m);
  };
  tilt(450, 0.08F);
  tilt(900, 0.11F);
  tilt(2100, 0.15F);
  return out.normalized();
}

float pore_shade(const Vec3f& neutral_m, float footprint_m) {
  constexpr float kPer_m = 1250;
  const float share = seen(kPer_m, footprint_m);
  if (share <= 0) return 1;
  const float noise = solid_noises(neutral_m * kPer_m).z();
  return 1 - 0.35F * share * std::max(0.0F, noise - 0.12F);
}

float freckle_cover(const Vec3f& neutral_m, float person, float amount, float footprint_m) {
  const Vec3f p = moved(neutral_m, person);
  float cover = 0;
  const auto add = [&](float side_m, float share) {
    const Cell cell = cell_at(p, side_m);
    float here = 0;
    if (cell.chance <= share * amount) {
      const float radius_m = side_m * (0.13F + 0.12F * cell.size);
      const float ragged = 1 + 0.3F * solid_noise(p * (1.1F / radius_m));
      here = (0.25F + 0.6F * cell.strength) *
             dot_cover(cell.from_dot.norm() * ragged, radius_m, footprint_m, side_m);
    }
    constexpr float kMeanCube = 0.007543F, kMeanStrength = 0.55F;  // Of radius^3 in sides^3.
    cover += averaged(here, std::min(1.0F, share * amount) * kMeanStrength * kSoftBall * kMeanCube,
                      footprint_m, side_m);
  };
  add(0.0052F, 0.9F);
  add(0.0033F, 0.9F);
  add(0.0021F, 0.6F);
  return std::min(cover, 1.0F);
}

float stubble_cover(const Vec3f& neutral_m, float person, float amount, float footprint_m) {
  const Vec3f p = moved(neutral_m, person);
  float cover = 0;
  // Two sets of cubes hide each other's rows.
  for (const float side_m : {0.00071F, 0.00093F}) {
    const Cell cell = cell_at(p, side_m);
    const float radius_m = side_m * (0.17F + 0.07F * cell.size);
    const float here =
        (0.55F + 0.45F * cell.strength) * dot_cover(cell.from_dot.norm(), radius_m, footprint_m, side_m);
    constexpr float kMeanCube = 0.008866F, kMeanStrength = 0.775F;
    cover += averaged(here, kMeanStrength * kSoftBall * kMeanCube, footprint_m, side_m);
  }
  return 0.8F * amount * std::min(cover, 1.0F);
}

}  // namespace mien::render
