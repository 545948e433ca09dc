#include "mien/virtual/headset/watched_parts.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <optional>

#include "mien/face/shape_region.h"

namespace mien::virt {
namespace {

/// So many are asked for in each picture.
constexpr std::size_t kWatched = 48;
/// A shape moves what it moves so far at weight 1.
constexpr float kMoves_m = 1e-3F;
/// Levels of a picture that tell nothing.
constexpr std::uint8_t kWhite = 250, kBlack = 8;

/// The pixel's place in the picture; none outside of it.
std::optional<std::size_t> pixel_of(const render::Lens& lens, const Vec3f& p_m) {
  const render::ScreenPoint p = lens.project(p_m);
  const int x = p.x / render::kSubpixels, y = p.y / render::kSubpixels;
  if (!(p.inverse_depth > 0) || p.x < 0 || p.y < 0 || x >= lens.width || y >= lens.height) return {};
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(lens.width) + static_cast<std::size_t>(x);
}

/// Whether a triangle, either side of it, crosses the way from `from` to `to` (Moeller and Trumbore 1997,
/// doi:10.1080/10867651.1997.10487468).
bool crosses(const Vec3f& from, const Vec3f& to, const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const Vec3f way = to - from, ab = b - a, ac = c - a;
  const Vec3f p = way.cross(ac);
  const float det = ab.dot(p);
  if (det == 0) return false;
  const Vec3f begin = (from - a) / det;
  const float u = begin.dot(p);
  if (!(u >= 0 && u <= 1)) return false;
  const Vec3f q = begin.cross(ab);
  const float v = way.dot(q);
  if (!(v >= 0 && u + v <= 1)) return false;
  const float t = ac.dot(q);
  return t > 0 && t < 1;
}

bool hides(const HidingMesh& thing, const Vec3f& from_m, const Vec3f& to_m) {
  return std::ranges::any_of(thing.triangles, [&](const std::array<std::uint32_t, 3>& t) {
    return crosses(from_m, to_m, thing.vertices_m[t[0]], thing.vertices_m[t[1]], thing.vertices_m[t[2]]);
  });
}

}  // namespace

std::vector<std::uint32_t> watched_vertices(const face::Face& face, bool of_mouth, const render::Lens& lens) {
  const auto region = of_mouth ? face::ShapeRegion::mouth : face::ShapeRegion::eyes;
  const std::vector<bool> skin = face.vertices_of(face::Material::skin),
                          lips = face.vertices_of(face::Material::lips);
  std::vector<bool> moves(face.neutral_m.size());
  for (std::size_t k = 0; k < std::min(face.shapes.size(), face::kShapeCount); ++k) {
    if (face::kShapeRegions[k] != region) continue;
    const face::Shape& shape = face.shapes[k];
    for (std::size_t i = 0; i < shape.vertex.size(); ++i)
      if ((skin[shape.vertex[i]] || lips[shape.vertex[i]]) && shape.delta_m[i].norm() > kMoves_m)
        moves[shape.vertex[i]] = true;
  }
  std::vector<std::uint32_t> shown;
  for (std::uint32_t v = 0; v < moves.size(); ++v)
    if (moves[v] && pixel_of(lens, face.neutral_m[v])) shown.push_back(v);
  std::vector<std::uint32_t> watched;
  for (std::size_t i = 0; i < std::min(kWatched, shown.size()); ++i)
    watched.push_back(shown[i * shown.size() / std::min(kWatched, shown.size())]);
  return watched;
}

double hidden_share(std::span<const std::uint32_t> watched, std::span<const Vec3f> face_m,
                    const HidingMesh& thing, const render::Lens& lens,
                    std::span<const std::uint8_t> picture) {
  assert(picture.empty() ||
         picture.size() == static_cast<std::size_t>(lens.width) * static_cast<std::size_t>(lens.height));
  if (watched.empty()) return 0;
  const auto hidden = std::ranges::count_if(watched, [&](std::uint32_t v) {
    const auto pixel = pixel_of(lens, face_m[v]);
    if (!pixel || hides(thing, lens.position_m, face_m[v])) return true;
    return !picture.empty() && (picture[*pixel] >= kWhite || picture[*pixel] <= kBlack);
  });
  return static_cast<double>(hidden) / static_cast<double>(watched.size());
}

}  // namespace mien::virt
