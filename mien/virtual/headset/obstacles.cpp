#include "mien/virtual/headset/obstacles.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace mien::virt {
namespace {

constexpr float kTurn = 2 * std::numbers::pi_v<float>;
/// Sides of a tube's cross-section.
constexpr std::uint32_t kSides = 8;

float drawn(Random& random, double least, double most) {
  return static_cast<float>(random.uniform(least, most));
}

/// Rows of vertices to triangles; `closed` joins each row's ends.
void sew(Obstacle& mesh, std::uint32_t first, std::uint32_t rows, std::uint32_t columns, bool closed) {
  for (std::uint32_t r = 0; r + 1 < rows; ++r)
    for (std::uint32_t c = 0; c + (closed ? 0 : 1) < columns; ++c) {
      const std::uint32_t next = (c + 1) % columns;
      const std::uint32_t a = first + r * columns + c, b = first + r * columns + next;
      mesh.thing.triangles.push_back({a, b, b + columns});
      mesh.thing.triangles.push_back({a, b + columns, a + columns});
    }
}

void add_ellipsoid(Obstacle& mesh, const Vec3f& middle_m, const Vec3f& radii_m) {
  constexpr std::uint32_t kRows = 9, kColumns = 14;
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  for (std::uint32_t r = 0; r < kRows; ++r)
    for (std::uint32_t c = 0; c < kColumns; ++c) {
      const float down = 0.5F * kTurn * static_cast<float>(r) / (kRows - 1);
      const float around = kTurn * static_cast<float>(c) / kColumns;
      mesh.vertices_m.emplace_back(middle_m + Vec3f(std::sin(down) * std::cos(around), std::cos(down),
                                                    std::sin(down) * std::sin(around))
                                                  .cwiseProduct(radii_m));
    }
  sew(mesh, first, kRows, kColumns, true);
}

Obstacle finished(Obstacle mesh) {
  mesh.thing.vertices = mesh.vertices_m.size();
  return mesh;
}

}  // namespace

void add_tube(Obstacle& mesh, const std::vector<Vec3f>& path_m, float radius_m, bool closed) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  const std::size_t count = path_m.size(), rows = count + (closed ? 1 : 0);
  for (std::size_t i = 0; i < rows; ++i) {
    const Vec3f& here = path_m[i % count];
    const Vec3f& before = i == 0 && !closed ? here : path_m[(i + count - 1) % count];
    const Vec3f& after = i + 1 == count && !closed ? here : path_m[(i + 1) % count];
    const Vec3f along = (after - before).normalized();
    const Vec3f side = along.cross(std::abs(along.z()) < 0.9F ? Vec3f::UnitZ() : Vec3f::UnitX()).normalized();
    const Vec3f up = along.cross(side);
    // Its ends are closed by drawing them together.
    const float radius = !closed && (i == 0 || i + 1 == count) ? 0.3F * radius_m : radius_m;
    for (std::uint32_t s = 0; s < kSides; ++s) {
      const float turn = kTurn * static_cast<float>(s) / kSides;
      mesh.vertices_m.emplace_back(here + radius * (std::cos(turn) * side + std::sin(turn) * up));
    }
  }
  sew(mesh, first, static_cast<std::uint32_t>(rows), kSides, true);
}

Obstacle make_hand(Random& random) {
  Obstacle hand;
  hand.thing.albedo = drawn(random, 0.42, 0.68);
  hand.thing.shine = 0.028F;
  const float size = drawn(random, 0.85, 1.15), curl = drawn(random, 0.0, 0.5);
  add_ellipsoid(hand, Vec3f(0, -0.02F * size, 0.006F), size * Vec3f(0.042F, 0.05F, 0.013F));
  for (int finger = 0; finger < 4; ++finger) {
    const float x = size * 0.0205F * (static_cast<float>(finger) - 1.5F);
    const float length = size * (finger == 1 || finger == 2 ? 0.08F : finger == 0 ? 0.07F : 0.058F);
    std::vector<Vec3f> path;
    for (int i = 0; i <= 5; ++i) {
      const float t = static_cast<float>(i) / 5;
      path.emplace_back(x, size * 0.022F + length * t * (1 - 0.3F * curl * t), -curl * 0.03F * t * t);
    }
    add_tube(hand, path, size * 0.0088F, false);
  }
  std::vector<Vec3f> thumb;
  for (int i = 0; i <= 4; ++i) {
    const float t = static_cast<float>(i) / 4;
    thumb.emplace_back(size * (0.035F + 0.03F * t), size * (-0.03F + 0.045F * t), -0.006F * t);
  }
  add_tube(hand, thumb, size * 0.0105F, false);
  return finished(std::move(hand));
}

Obstacle make_cup(Random& random) {
  Obstacle cup;
  cup.thing.albedo = drawn(random, 0.08, 0.8);
  cup.thing.shine = drawn(random, 0.02, 0.08);
  const float radius = drawn(random, 0.03, 0.045), height = drawn(random, 0.07, 0.12);
  const float narrow = drawn(random, 0.7, 1.0);
  constexpr std::uint32_t kRows = 6, kColumns = 28;
  for (std::uint32_t r = 0; r < kRows; ++r)
    for (std::uint32_t c = 0; c < kColumns; ++c) {
      const float t = static_cast<float>(r) / (kRows - 1), turn = kTurn * static_cast<float>(c) / kColumns;
      const float at = radius * std::lerp(1.0F, narrow, t);
      cup.vertices_m.emplace_back(at * std::cos(turn), -height * t, radius + at * std::sin(turn));
    }
  sew(cup, 0, kRows, kColumns, true);
  return finished(std::move(cup));
}

Obstacle make_mask(Random& random) {
  Obstacle mask;
  mask.thing.albedo = drawn(random, 0.15, 0.75);
  const float width = drawn(random, 0.058, 0.068), depth = drawn(random, 0.030, 0.040);
  constexpr std::uint32_t kRows = 12, kColumns = 18;
  for (std::uint32_t r = 0; r < kRows; ++r)
    for (std::uint32_t c = 0; c < kColumns; ++c) {
      const float v = 2 * static_cast<float>(r) / (kRows - 1) - 1,
                  u = 2 * static_cast<float>(c) / (kColumns - 1) - 1;
      const float folds = 0.0008F * std::sin(9 * v);
      mask.vertices_m.emplace_back(
          width * u, -0.012F - 0.045F * v,
          depth * std::sqrt(std::max(0.0F, 1.05F - u * u)) * (1 - 0.35F * v * v) - 0.018F + folds);
    }
  sew(mask, 0, kRows, kColumns, false);
  return finished(std::move(mask));
}

Obstacle make_spectacles(float eye_x_m, Random& random) {
  Obstacle frame;
  frame.thing.albedo = drawn(random, 0.04, 0.35);
  frame.thing.shine = drawn(random, 0.03, 0.12);
  const float tube = drawn(random, 0.0008, 0.0022), width = drawn(random, 0.021, 0.026);
  const float height = drawn(random, 0.016, 0.022), squareness = drawn(random, 2.0, 4.5);
  for (const float side : {-1.0F, 1.0F}) {
    std::vector<Vec3f> ring;
    for (int i = 0; i < 28; ++i) {
      // Superellipse: between round and rectangular.
      const float turn = kTurn * static_cast<float>(i) / 28, x = std::cos(turn), y = std::sin(turn);
      const auto shaped = [&](float t) { return std::copysign(std::pow(std::abs(t), 2 / squareness), t); };
      ring.emplace_back(side * eye_x_m + width * shaped(x), height * shaped(y), -0.003F * x * x);
    }
    add_tube(frame, ring, tube, true);
    const float end = side * (eye_x_m + width);
    add_tube(frame,
             {Vec3f(end, 0.006F, -0.003F), Vec3f(end + side * 0.008F, 0.007F, -0.012F),
              Vec3f(end + side * 0.013F, 0.006F, -0.04F), Vec3f(end + side * 0.014F, 0.002F, -0.09F)},
             tube, false);
  }
  const float inner = eye_x_m - width;
  add_tube(frame, {Vec3f(-inner, 0.003F, 0), Vec3f(0, 0.006F, 0.002F), Vec3f(inner, 0.003F, 0)}, tube, false);
  return finished(std::move(frame));
}

}  // namespace mien::virt
