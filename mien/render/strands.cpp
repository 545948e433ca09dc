#include "mien/render/strands.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "mien/core/smoothstep.h"
#include "mien/render/image.h"
#include "mien/render/tone.h"

namespace mien::render {

namespace {

constexpr int kHairs = static_cast<int>(face::kStrandsPerUv);
constexpr int kRows = 128, kPlaces = 16;  // Of the table: from root to tip, and to each hair.

/// One hair at its distance `v` from the root, 0 to 1. Across the ribbon, in hairs from where its own cell
/// begins.
struct HairProfile {
  float middle = 0.5F, half = 0, brightness = 1;
};

HairProfile profile_of(int hair, float v) {
  std::uint32_t h = (static_cast<std::uint32_t>(hair) + 1) * 0x9E3779B1U;
  h = (h ^ (h >> 15U)) * 0x85EBCA77U;
  h ^= h >> 13U;
  const auto part = [h](unsigned shift) { return static_cast<float>(h >> shift & 255U) / 255.0F; };
  const float end = 0.70F + 0.30F * part(16), begin = 0.14F * part(4);
  return {.middle = 0.5F + 0.18F * std::sin(6.2831853F * (part(0) + v * (0.4F + part(8)))),
          .half = 0.42F * std::pow(std::max(0.0F, 1 - v / end), 0.55F) *
                  smoothstep(begin - 0.02F, begin + 0.08F, v),
          .brightness = 0.75F + 0.5F * part(24)};
}

/// What hairs cover from the ribbon's edge on, summed, and the same weighted by their brightness: a mean over
/// any width is then two look-ups. Source: Crow 1984, "Summed-area tables", doi:10.1145/800031.808600; here
/// along rows only.
class CoverSums {
 public:
  CoverSums() : sum_(static_cast<std::size_t>(kRows + 1) * kStride, Eigen::Vector2f::Zero()) {
    for (int row = 0; row <= kRows; ++row)
      for (int hair = 0; hair < kHairs; ++hair) {
        const HairProfile profile = profile_of(hair, static_cast<float>(row) / kRows);
        const float left = std::max(0.0F, profile.middle - profile.half),
                    right = std::min(1.0F, profile.middle + profile.half);
        const Eigen::Vector2f before = sum_[at(row, hair * kPlaces)];
        for (int step = 1; step <= kPlaces; ++step) {
          const float x = static_cast<float>(step) / kPlaces;
          const float covered = std::max(0.0F, std::min(x, right) - left);
          sum_[at(row, hair * kPlaces + step)] =
              before + Eigen::Vector2f(covered, covered * profile.brightness);
        }
      }
  }

  /// Between `across` and `across + width` hairs, at `v`: the covered width, and the same times its
  /// brightness.
  [[nodiscard]] Eigen::Vector2f between(float across, float width, float v) const {
    const float row = std::clamp(v, 0.0F, 1.0F) * kRows;
    const int above = std::min(static_cast<int>(row), kRows - 1);
    const float t = row - static_cast<float>(above);
    across -= std::floor(across / kHairs) * kHairs;
    return (1 - t) * (until(above, across + width) - until(above, across)) +
           t * (until(above + 1, across + width) - until(above + 1, across));
  }

 private:
  static constexpr std::size_t kStride = kHairs * kPlaces + 1;
  static std::size_t at(int row, int step) {
    return static_cast<std::size_t>(row) * kStride + static_cast<std::size_t>(step);
  }
  [[nodiscard]] Eigen::Vector2f until(int row, float across) const {
    const float step = across * kPlaces;
    const int whole = static_cast<int>(step);
    const int turns = whole / (kHairs * kPlaces), rest = whole - turns * kHairs * kPlaces;
    const Eigen::Vector2f here = sum_[at(row, rest)];
    return static_cast<float>(turns) * sum_[at(row, kHairs * kPlaces)] + here +
           (step - static_cast<float>(whole)) * (sum_[at(row, rest + 1)] - here);
  }
  std::vector<Eigen::Vector2f> sum_;
};

}  // namespace

Strand strand_at(const Eigen::Vector2f& uv, float width) {
  static const CoverSums kSums;
  width = std::clamp(width, 1.0F / kPlaces, 0.5F * kHairs);
  const Eigen::Vector2f sum = kSums.between(uv.x() * face::kStrandsPerUv - 0.5F * width, width, uv.y());
  return {.cover = sum.x() / width, .brightness = sum.x() > 1e-6F ? sum.y() / sum.x() : 1.0F};
}

Result<std::vector<std::byte>> strands_png() {
  constexpr int kPixelsPerStrand = 8, kWidth = static_cast<int>(face::kStrandsPerUv) * kPixelsPerStrand,
                kHeight = 128;
  std::vector<std::uint8_t> rgba;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const Eigen::Vector2f uv((static_cast<float>(x) + 0.5F) / kWidth,
                               (static_cast<float>(y) + 0.5F) / kHeight);
      const Strand strand = strand_at(uv, 2.0F / kPixelsPerStrand);
      const Rgb grey = to_srgb(Vec3f::Constant(strand.brightness / face::kBrightestStrand));
      rgba.insert(rgba.end(), grey.begin(), grey.end());
      rgba.push_back(static_cast<std::uint8_t>(255 * strand.cover + 0.5F));
    }
  return encode_png(kWidth, kHeight, PngPixels::rgba, rgba);
}

Vec3f rounded_hair(const Vec3f& p_m, const Vec3f& normal, const Vec3f& middle_m) {
  const Vec3f out = (p_m - middle_m).normalized();
  return (out + (normal.dot(out) < 0 ? -0.7F : 0.7F) * normal).normalized();
}

void round_hair(std::span<const Vec3f> vertices_m, const std::vector<bool>& is_strand, const Vec3f& middle_m,
                std::span<Vec3f> normals) {
  for (std::size_t i = 0; i < normals.size(); ++i)
    if (is_strand[i]) normals[i] = rounded_hair(vertices_m[i], normals[i], middle_m);
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
