#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mien/render/parallel.h"
#include "mien/render/renderer_state.h"

namespace mien::render {
namespace {

const Vec3f kLash(0.012F, 0.009F, 0.008F);
const Vec3f kHairColour(0.055F, 0.035F, 0.025F);
/// A pixel shows the mean of the hairs over this many of its width, so that they do not flicker as they move.
constexpr float kBlur = 1.4F;

/// Along a hair from root to tip and across the ribbon, from how uv lies on a triangle: metres for a unit of
/// uv.
struct RibbonAxes {
  Vec3f across = Vec3f::Zero(), along = Vec3f::Zero();
};

RibbonAxes ribbon_axes(const std::array<Vec3f, 3>& p, const std::array<Eigen::Vector2f, 3>& uv) {
  const Eigen::Vector2f d1 = uv[1] - uv[0], d2 = uv[2] - uv[0];
  const float det = d1.x() * d2.y() - d1.y() * d2.x();
  if (std::abs(det) < 1e-12F) return {};
  const Vec3f e1 = p[1] - p[0], e2 = p[2] - p[0];
  return {.across = (d2.y() * e1 - d1.y() * e2) / det, .along = (d1.x() * e2 - d2.x() * e1) / det};
}

}  // namespace

void Renderer::State::shade_hair(bool in_error_colours) {
  HairLight& out = hair_light[in_error_colours ? 1 : 0];
  const auto shade_list = [&](const std::vector<std::uint32_t>& triangles) {
    std::vector<std::uint32_t> vertices;
    for (const std::uint32_t t : triangles) {
      if (material[t] != Material::strands) continue;
      for (const std::uint32_t i : face.triangles[t]) {
        out.tint[i].setZero();
        vertices.push_back(i);
      }
    }
    std::ranges::sort(vertices);
    vertices.erase(std::ranges::unique(vertices).begin(), vertices.end());
    // The direction of a hair at a vertex, kept where its light comes to stand.
    for (const std::uint32_t t : triangles) {
      if (material[t] != Material::strands) continue;
      const auto& [a, b, c] = face.triangles[t];
      const Vec3f along =
          ribbon_axes({position[a], position[b], position[c]}, {face.uv[a], face.uv[b], face.uv[c]}).along;
      for (const std::uint32_t i : face.triangles[t]) out.tint[i] += along;
    }
    parallel(workers, vertices.size(), 512, [&](std::size_t first, std::size_t last) {
      for (std::size_t k = first; k < last; ++k) {
        const std::uint32_t i = vertices[k];
        const Vec3f albedo = in_error_colours      ? Vec3f(0.4F * error_colour(0))
                             : face.colour.empty() ? kHairColour
                                                   : face.colour[i];
        const float length = out.tint[i].norm();
        const Vec3f along = length > 1e-12F ? Vec3f(out.tint[i] / length) : Vec3f::UnitY();
        shade_strand(i, along, albedo, &out.tint[i], &out.gloss[i]);
      }
    });
  };
  if (!out.moving_known) shade_list(moving_hair_triangle);
  if (!out.still_known) {
    shade_list(still_hair_triangle);
    out.still.clear();
    out.tile.clear();
  }
  out.moving_known = out.still_known = true;
}

/// Light that a hair throws back: diffuse about it, a white highlight shifted to its root and one of its own
/// colour shifted to its tip. Source: Kajiya and Kay 1989, doi:10.1145/74334.74361; the shifts after
/// Scheuermann 2004, "Practical real-time hair rendering and shading". Strengths chosen by eye.
void Renderer::State::shade_strand(std::uint32_t i, const Vec3f& along, const Vec3f& albedo, Vec3f* tint,
                                   Vec3f* gloss) const {
  const auto lobe = [](const Vec3f& axis, const Vec3f& half, float exponent) {
    const float cosine = axis.dot(half);
    return std::pow(std::max(0.0F, 1 - cosine * cosine), 0.5F * exponent);
  };
  const Vec3f to_camera = (view.eye_m - position[i]).normalized();
  const Vec3f to_root = (along + 0.06F * normal[i]).normalized();
  const Vec3f to_tip = (along - 0.12F * normal[i]).normalized();
  *tint = albedo.cwiseProduct(ambient_of(light[i]));
  gloss->setZero();
  for (std::size_t l = 0; l < kLights; ++l) {
    const Look::Light& lamp = studio.light[l];
    const float visible = visible_of(light[i], l).y();
    if (visible <= 0) continue;
    const float cosine = along.dot(lamp.direction);
    const float around = std::sqrt(std::max(0.0F, 1 - cosine * cosine));
    const float facing = std::clamp((normal[i].dot(lamp.direction) + 0.35F) / 1.35F, 0.0F, 1.0F);
    const Vec3f half = (lamp.direction + to_camera).normalized();
    const Vec3f arrives = visible * facing / kPi * lamp.radiance;
    *tint += (albedo * (0.35F + 0.65F * around) + albedo.cwiseSqrt() * (0.16F * lobe(to_tip, half, 22)))
                 .cwiseProduct(arrives);
    *gloss += 0.05F * lobe(to_root, half, 110) * arrives;
  }
}

void Renderer::State::gather_hair(std::span<const std::uint32_t> triangles, const HairLight& colours,
                                  int left, int top, TileHair* hair_of_tile) const {
  const PixelBox tile = {left, top, std::min(left + kTile, view.width), std::min(top + kTile, view.height)};
  for (const std::uint32_t t : triangles) {
    const auto& [a, b, c] = face.triangles[t];
    const ScreenTriangle triangle(on_screen[a], on_screen[b], on_screen[c]);
    const bool is_lash = material[t] == Material::lash;
    if (!is_lash && face.uv.empty()) continue;
    const auto uv = [&](std::size_t axis) -> std::array<float, 3> {
      const auto k = static_cast<Eigen::Index>(axis);
      return {face.uv[a][k], face.uv[b][k], face.uv[c][k]};
    };
    const float width = is_lash ? 0 : kBlur * face::kStrandsPerUv * triangle.gradient(uv(0)).norm();
    triangle.scan(tile, [&](int x, int y, Coverage coverage) {
      const Eigen::Vector2f middle = middle_of(coverage);
      const SeenPlace seen = {
          .triangle = t,
          .weight = triangle.weights(static_cast<float>(x) + middle.x(), static_cast<float>(y) + middle.y()),
          .to_camera = {}};
      HairFragment fragment;
      if (is_lash) {
        fragment.cover = paint.lash_cover(between(seen, face.neutral_m), between(seen, lash_length_m));
        fragment.light = kLash;
      } else {
        const Strand strand = strand_at(between(seen, face.uv), width);
        fragment.cover = strand.cover;
        fragment.light = strand.brightness * between(seen, colours.tint) + between(seen, colours.gloss);
      }
      if (fragment.cover < 1e-3F) return;
      const auto& depths = triangle.inverse_depth();
      // In perspective the depth itself is the weighted mean.
      fragment.inverse_depth =
          1 / (seen.weight[0] / depths[0] + seen.weight[1] / depths[1] + seen.weight[2] / depths[2]);
      fragment.pixel = static_cast<std::uint16_t>((y - top) * kTile + x - left);
      fragment.samples = static_cast<std::uint8_t>(coverage);
      hair_of_tile->add(fragment);
    });
  }
}

}  // namespace mien::render
