#include "mien/render/strands.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "mien/core/smoothstep.h"
#include "mien/render/image.h"
#include "mien/render/tone.h"

namespace mien::render {

Strand strand_at(const Eigen::Vector2f& uv, float softness) {
  const float across = uv.x() * face::kStrandsPerUv;
  const float number = std::floor(across);
  const auto cell = static_cast<std::uint32_t>(static_cast<std::int64_t>(number) &
                                               (static_cast<std::int64_t>(face::kStrandsPerUv) - 1));
  std::uint32_t h = (cell + 1) * 0x9E3779B1U;
  h = (h ^ (h >> 15U)) * 0x85EBCA77U;
  h ^= h >> 13U;
  const auto part = [h](unsigned shift) { return static_cast<float>(h >> shift & 255U) / 255.0F; };
  const float v = std::clamp(uv.y(), 0.0F, 1.0F);
  const float middle = 0.5F + 0.18F * std::sin(6.2831853F * (part(0) + v * (0.4F + part(8))));
  const float end = 0.84F + 0.16F * part(16), begin = 0.07F * part(4);
  const float half =
      0.42F * std::sqrt(std::max(0.0F, 1 - v / end)) * smoothstep(begin - 0.02F, begin + 0.08F, v);
  Strand strand;
  strand.cover = smoothstep(half + softness, half - softness, std::abs(across - number - middle));
  // A hair thinner than its soft edge covers less, not nothing.
  strand.cover *= std::min(1.0F, 2 * half / std::max(softness, 1e-3F));
  strand.brightness = 0.75F + 0.5F * part(24);
  return strand;
}

Result<std::vector<std::byte>> strands_png() {
  constexpr int kPixelsPerStrand = 8, kWidth = static_cast<int>(face::kStrandsPerUv) * kPixelsPerStrand,
                kHeight = 128;
  std::vector<std::uint8_t> rgba;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const Eigen::Vector2f uv((static_cast<float>(x) + 0.5F) / kWidth,
                               (static_cast<float>(y) + 0.5F) / kHeight);
      const Strand strand = strand_at(uv, 1.0F / kPixelsPerStrand);
      const Rgb grey = to_srgb(Vec3f::Constant(strand.brightness / face::kBrightestStrand));
      rgba.insert(rgba.end(), grey.begin(), grey.end());
      rgba.push_back(static_cast<std::uint8_t>(255 * strand.cover + 0.5F));
    }
  return encode_png(kWidth, kHeight, PngPixels::rgba, rgba);
}

void round_hair(std::span<const Vec3f> vertices_m, const std::vector<bool>& is_strand, const Vec3f& middle_m,
                std::span<Vec3f> normals) {
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (!is_strand[i]) continue;
    const Vec3f out = (vertices_m[i] - middle_m).normalized();
    normals[i] = (out + (normals[i].dot(out) < 0 ? -0.7F : 0.7F) * normals[i]).normalized();
  }
}

Vec3f middle_of_head_m(const face::Face& face) {
  Vec3f sum = Vec3f::Zero();
  float count = 0;
  const std::vector<bool> is_strand = face.vertices_of(face::Material::strands);
  for (const auto& triangle : face.triangles) {
    if (is_strand[triangle[0]]) continue;
    sum += face.neutral_m[triangle[0]];
    ++count;
  }
  return count > 0 ? Vec3f(sum / count) : sum;
}

}  // namespace mien::render
