#pragma once

#include <cmath>
#include <numbers>

#include "mien/face/face.h"

namespace mien::render {

/// Adds a ball and gives the index of its first vertex.
inline std::uint32_t add_ball(face::Face& face, const std::string& name, face::Material material,
                              const Vec3f& centre_m, float radius_m, int rings) {
  const auto first = static_cast<std::uint32_t>(face.neutral_m.size());
  const auto first_triangle = static_cast<std::uint32_t>(face.triangles.size());
  const int columns = 2 * rings;
  for (int r = 0; r <= rings; ++r)
    for (int c = 0; c < columns; ++c) {
      const float down = std::numbers::pi_v<float> * static_cast<float>(r) / static_cast<float>(rings);
      const float turn = 2 * std::numbers::pi_v<float> * static_cast<float>(c) / static_cast<float>(columns);
      face.neutral_m.push_back(centre_m + radius_m * Vec3f(std::sin(down) * std::cos(turn), std::cos(down),
                                                           -std::sin(down) * std::sin(turn)));
    }
  for (int r = 0; r < rings; ++r)
    for (int c = 0; c < columns; ++c) {
      const auto at = [&](int row, int column) {
        return first + static_cast<std::uint32_t>(row * columns + column % columns);
      };
      if (r > 0) face.triangles.push_back({at(r, c), at(r + 1, c), at(r, c + 1)});
      if (r < rings - 1) face.triangles.push_back({at(r, c + 1), at(r + 1, c), at(r + 1, c + 1)});
    }
  face.parts.push_back(
      {name, material, first_triangle, static_cast<std::uint32_t>(face.triangles.size()) - first_triangle});
  return first;
}

/// A head for tests: a ball of skin 0.2 m wide with two eyeballs that stand out of its front. Two of its
/// shapes move something: jawOpen draws the lower half down by up to 2 cm, mouthSmile_L the left side
/// outwards by up to 1 cm.
inline face::Face ball_face() {
  face::Face face;
  face.name = "ball";
  add_ball(face, "skin", face::Material::skin, Vec3f::Zero(), 0.1F, 24);
  const auto skin = static_cast<std::uint32_t>(face.neutral_m.size());
  for (std::size_t e = 0; e < 2; ++e) {
    const Vec3f centre(e == 0 ? 0.035F : -0.035F, 0.03F, 0.085F);
    const std::uint32_t first =
        add_ball(face, e == 0 ? "eye_L" : "eye_R", face::Material::sclera, centre, 0.014F, 10);
    face.eyes[e] = {first, static_cast<std::uint32_t>(face.neutral_m.size()) - first, centre};
  }
  face::Region region{"skin", {}};
  for (std::uint32_t i = 0; i < skin; ++i) region.vertex.push_back(i);
  face.regions.push_back(region);
  for (const auto name : face::kShapeNames) face.shapes.push_back({std::string(name), {}, {}});
  face::Shape& jaw = face.shapes[face::shape("jawOpen")];
  face::Shape& smile = face.shapes[face::shape("mouthSmile_L")];
  for (std::uint32_t i = 0; i < skin; ++i) {
    const Vec3f& p = face.neutral_m[i];
    if (p.y() < 0) {
      jaw.vertex.push_back(i);
      jaw.delta_m.emplace_back(0.0F, 0.2F * p.y(), 0.0F);
    }
    if (p.x() > 0) {
      smile.vertex.push_back(i);
      smile.delta_m.emplace_back(0.1F * p.x(), 0.0F, 0.0F);
    }
  }
  return face;
}

}  // namespace mien::render
