#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "mien/render/parallel.h"
#include "mien/render/renderer_state.h"

namespace mien::render {
namespace {

/// Rays start this far from the skin so that it does not block itself: well under a lid's thickness.
constexpr float kClear_m = 2e-4F;
/// Rays to lights start higher above the skin: light enters some way from where it leaves, and the border of
/// shadow on a curved cheek is soft.
constexpr float kScatterHeight_m = 1.2e-3F;
/// How far light spreads in skin, red, green, blue: mean free paths of some millimetres and less
/// (Jensen et al. 2001, doi:10.1145/383259.383319, table 1), as the deviation of a Gaussian.
const Vec3f kScatter_m(3.4e-3F, 1.5e-3F, 0.9e-3F);

/// Of the light that meets hair, the part that comes out behind it; chosen by eye.
constexpr float kThroughHair = 0.4F;
/// Hair nearer than this to a place of hair belongs to the same lock.
constexpr float kOwnLock_m = 5e-3F;

}  // namespace

void Renderer::State::find_neighbours() {
  const std::size_t n = face.neutral_m.size();
  position = face.neutral_m;

  // Importers split vertices where texture coordinates break; skin does not break there.
  normal.resize(n);
  face::vertex_normals(face, position, normal);
  std::vector<std::uint32_t> order(n);
  for (std::size_t i = 0; i < n; ++i) order[i] = static_cast<std::uint32_t>(i);
  const auto key = [&](std::uint32_t i) {
    const Vec3f& p = face.neutral_m[i];
    return std::array<float, 3>{p.x(), p.y(), p.z()};
  };
  std::ranges::sort(
      order, [&](std::uint32_t a, std::uint32_t b) { return std::pair(key(a), a) < std::pair(key(b), b); });
  twin.resize(n);
  for (std::size_t i = 0, first = 0; i < n; ++i) {
    if (key(order[i]) != key(order[first])) first = i;
    twin[order[i]] = order[i];
    for (std::size_t j = first; j < i; ++j)
      if (twin[order[j]] == order[j] && normal[order[i]].dot(normal[order[j]]) > 0.3F) {
        twin[order[i]] = order[j];
        break;
      }
  }

  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  lit_by_vertex.assign(n, false);
  scatters.assign(n, false);
  for (std::size_t t = 0; t < face.triangles.size(); ++t) {
    if (material[t] == Material::skin || material[t] == Material::lips)
      for (const std::uint32_t i : face.triangles[t]) scatters[i] = true;
    if (is_eye(material[t]) || layer[t] != Layer::solid) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = twin[face.triangles[t][c]], b = twin[face.triangles[t][(c + 1) % 3]];
      lit_by_vertex[a] = true;
      if (a == b) continue;
      edges.emplace_back(a, b);
      edges.emplace_back(b, a);
    }
  }
  has_hair = std::ranges::find(material, Material::strands) != material.end();
  for (std::size_t i = 0; i < n; ++i)
    if (is_strand[i]) lit_by_vertex[twin[i]] = true;
  std::ranges::sort(edges);
  edges.erase(std::ranges::unique(edges).begin(), edges.end());
  neighbour_start.assign(n + 1, 0);
  for (const auto& [a, b] : edges) ++neighbour_start[a + 1];
  for (std::size_t i = 0; i < n; ++i) neighbour_start[i + 1] += neighbour_start[i];
  spread_m.assign(n, 0);
  for (const auto& [a, b] : edges) {
    neighbour.push_back(b);
    spread_m[a] += (face.neutral_m[a] - face.neutral_m[b]).norm();
  }
  for (std::size_t i = 0; i < n; ++i)
    if (const auto count = neighbour_start[i + 1] - neighbour_start[i]; count > 0)
      spread_m[i] /= static_cast<float>(count);
}

void Renderer::State::measure_lashes() {
  const std::size_t n = face.neutral_m.size();
  lash_length_m.assign(n, 0);
  std::vector<bool> is_lash(n, false), is_skin(n, false);
  for (std::size_t t = 0; t < face.triangles.size(); ++t)
    for (const std::uint32_t i : face.triangles[t]) {
      if (material[t] == Material::lash) is_lash[i] = true;
      if (layer[t] != Layer::fringe) is_skin[i] = true;
    }
  Vec3f low = Vec3f::Constant(std::numeric_limits<float>::max()), high = -low;
  for (std::size_t i = 0; i < n; ++i)
    if (is_lash[i]) {
      low = low.cwiseMin(face.neutral_m[i]);
      high = high.cwiseMax(face.neutral_m[i]);
    }
  constexpr float kReach_m = 0.015F;
  std::vector<Vec3f> near;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3f& p = face.neutral_m[i];
    if (is_skin[i] && (p - low).minCoeff() > -kReach_m && (high - p).minCoeff() > -kReach_m)
      near.push_back(p);
  }
  parallel(threads, n, 512, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (!is_lash[i]) continue;
      float nearest2 = kReach_m * kReach_m;
      for (const Vec3f& p : near) nearest2 = std::min(nearest2, (p - face.neutral_m[i]).squaredNorm());
      lash_length_m[i] = std::sqrt(nearest2);
    }
  });
}

void Renderer::State::find_normals(std::span<const Vec3f> vertices_m) {
  std::ranges::copy(vertices_m, position.begin());
  std::ranges::fill(normal, Vec3f::Zero());
  for (const auto& [a, b, c] : face.triangles) {
    const Vec3f across = (position[b] - position[a]).cross(position[c] - position[a]);
    normal[twin[a]] += across;
    normal[twin[b]] += across;
    normal[twin[c]] += across;
  }
  for (std::size_t i = 0; i < normal.size(); ++i) {
    const float length = normal[i].norm();
    if (twin[i] == i) normal[i] = length > 1e-20F ? Vec3f(normal[i] / length) : Vec3f::UnitZ();
  }
  for (std::size_t i = 0; i < normal.size(); ++i) normal[i] = normal[twin[i]];
  round_hair(position, is_strand, middle_m, normal);

  for (std::size_t e = 0; e < 2; ++e) {
    const face::Eyeball& ball = face.eyes[e];
    eye_turn[e].setIdentity();
    if (ball.vertex_count < 4) continue;
    std::vector<Vec3> from, to;
    const std::uint32_t step = std::max(1U, ball.vertex_count / 64);
    for (std::uint32_t i = ball.first_vertex; i < ball.first_vertex + ball.vertex_count; i += step) {
      from.push_back(face.neutral_m[i].cast<double>());
      to.push_back(position[i].cast<double>());
    }
    eye_turn[e] = fit_rotation(from, to).toRotationMatrix().cast<float>();
  }
}

void Renderer::State::light_vertices(const Studio& studio) {
  const std::size_t n = position.size();
  ambient.assign(n, Vec3f::Zero());
  for (auto& part : visible) part.assign(n, Vec3f::Zero());
  // Of light from a direction, what hair lets through. A ribbon is no shade to itself and its neighbours.
  const auto in_hair = [&](std::size_t i, const Vec3f& d, float reach_m) {
    if (!has_hair) return 1.0F;
    const Vec3f from = position[i] + kScatterHeight_m * normal[i];
    return hair.blocked(from, d, is_strand[i] ? kOwnLock_m : 0, reach_m) ? kThroughHair : 1.0F;
  };
  parallel(threads, n, 256, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (twin[i] != i || !lit_by_vertex[i]) continue;
      const Vec3f& up = normal[i];
      // Of hair, which has most vertices and blurs its own light, a film takes fewer directions.
      const bool fewer = is_strand[i] && quality == Quality::video;
      const std::size_t every = fewer ? 4 : 1, every_of_lamp = fewer ? 3 : 1;
      float weights = 0;
      Vec3f light = Vec3f::Zero();
      for (std::size_t k = 0; k < ambient_directions.size(); k += every) {
        const Vec3f& d = ambient_directions[k];
        const float cosine = d.dot(up);
        if (cosine <= 0.02F) continue;
        weights += cosine;
        if (!solid.blocked(position[i] + kClear_m * up, d, 0, kAmbientReach_m))
          light += cosine * (fewer ? 1.0F : in_hair(i, d, kAmbientReach_m)) * studio.around(d);
      }
      if (weights > 0) ambient[i] = light / weights;
      for (std::size_t l = 0; l < kLights; ++l) {
        if (studio.light[l].direction.dot(up) < -0.45F) continue;
        float seen = 0, asked = 0;
        for (std::size_t k = 0; k < studio.light_samples[l].size(); k += every_of_lamp) {
          const Vec3f& d = studio.light_samples[l][k];
          ++asked;
          if (!solid.blocked(position[i] + kScatterHeight_m * up, d, 0, kFar_m))
            seen += in_hair(i, d, kFar_m);
        }
        visible[l][i].setConstant(seen / asked);
      }
    }
  });
}

void Renderer::State::scatter_light() {
  // Diffusion over the mesh: each step moves a vertex towards its neighbours' mean and adds lambda * edge^2
  // to the variance of the blur.
  constexpr int kSteps = 6;
  std::vector<Vec3f> next(position.size());
  const auto blur = [&](std::vector<Vec3f>& field, const Vec3f& scatter_m) {
    for (int step = 0; step < kSteps; ++step) {
      parallel(threads, position.size(), 2048, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
          next[i] = field[i];
          const std::uint32_t begin = neighbour_start[i], end = neighbour_start[i + 1];
          if (begin == end) continue;
          Vec3f mean = Vec3f::Zero();
          for (std::uint32_t k = begin; k < end; ++k) mean += field[neighbour[k]];
          mean /= static_cast<float>(end - begin);
          const float variance = std::max(1e-12F, kSteps * spread_m[i] * spread_m[i]);
          // Teeth and gums are not translucent as skin is: what spreads there has no colour.
          const Vec3f spread = scatters[i] ? scatter_m : Vec3f(Vec3f::Constant(scatter_m.z()));
          const Vec3f lambda = (spread.cwiseProduct(spread) / variance).cwiseMin(0.6F);
          next[i] += lambda.cwiseProduct(mean - field[i]);
        }
      });
      field.swap(next);
    }
  };
  for (auto& part : visible) blur(part, kScatter_m);
  blur(ambient, 0.7F * kScatter_m);
  for (std::size_t i = 0; i < position.size(); ++i) {
    if (twin[i] == i) continue;
    ambient[i] = ambient[twin[i]];
    for (auto& part : visible) part[i] = part[twin[i]];
  }
}

}  // namespace mien::render
