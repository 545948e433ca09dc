#include <algorithm>
#include <array>
#include <atomic>
#include <span>
#include <vector>

#include "mien/face/normals.h"
#include "mien/render/parallel.h"
#include "mien/render/renderer_state.h"

namespace mien::render {
namespace {

/// Rays start this far from the skin so that it does not block itself: well under a lid's thickness.
constexpr float kClear_m = 2e-4F;
/// Rays to lights start higher above the skin: light enters some way from where it leaves, and the border of
/// shadow on a curved cheek is soft.
constexpr float kScatterHeight_m = 1.2e-3F;

/// Of the light that meets hair, the part that comes out behind it; chosen by eye.
constexpr float kThroughHair = 0.4F;
/// Of the light that a direction would bring, what comes from the skin that stands in it; chosen by eye, the
/// colour that of one reflection from middle skin.
const Vec3f kBounce(0.30F, 0.19F, 0.15F);
/// Lamps that lips hide from teeth still light them, through the lips and from one to the other: this share,
/// where the mouth is wide open; chosen by eye.
constexpr float kAroundLips = 0.6F;
/// Hair nearer than this to a place of hair belongs to the same lock.
constexpr float kOwnLock_m = 5e-3F;
/// How far from what shapes move light is found anew for each pose.
constexpr float kNearMotion_m = 0.03F;
/// A light further round the vertex than this (cosine) does not reach it.
constexpr float kBehind = -0.45F;
/// A film takes the light of some vertices from those around, where edges are shorter than light spreads and
/// normals turn by less than this (cosine).
constexpr float kBetween_m = 3.5e-3F, kBetweenNormal = 0.94F;

/// Some of the directions from one vertex, and what came of asking for them.
struct Asked {
  std::array<Vec3f, kMostDirections> direction;
  std::array<std::uint8_t, kMostDirections> index, blocked;
  std::size_t count = 0;

  void clear() { count = 0; }
  void add(const Vec3f& d, std::size_t k) {
    direction[count] = d;
    index[count++] = static_cast<std::uint8_t>(k);
  }
  void ask(const RayScene& scene, const Vec3f& from, float near_m, float far_m) {
    scene.blocked(from, std::span(direction).first(count), near_m, far_m, std::span(blocked).first(count));
  }
};

}  // namespace

bool Renderer::State::hair_rests(std::span<const Vec3f> vertices_m) const {
  return std::ranges::all_of(still_vertex,
                             [&](std::uint32_t i) { return vertices_m[i] == face.neutral_m[i]; });
}

void Renderer::State::pose(std::span<const Vec3f> vertices_m, bool all) {
  std::ranges::copy(vertices_m, position.begin());
  find_normals(all);
  wrinkles.fold(position, folds);
  solid.move(vertices_m);
  if (all) hair.move(vertices_m);
  parallel(workers, position.size(), 4096, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i)
      if (all || !is_still[i]) on_screen[i] = view.project(position[i]);
  });
  solid_bins.sort(solid_triangle, face.triangles, on_screen, view.width, view.height);
  clear_bins.sort(clear_triangle, face.triangles, on_screen, view.width, view.height);
  moving_hair_bins.sort(moving_hair_triangle, face.triangles, on_screen, view.width, view.height);
  if (all) still_hair_bins.sort(still_hair_triangle, face.triangles, on_screen, view.width, view.height);
  for (HairLight& colours : hair_light) {
    colours.moving_known = false;
    if (all) colours.still_known = false;
  }
}

void Renderer::State::find_normals(bool all) {
  for (std::size_t i = 0; i < normal.size(); ++i)
    if (all || !is_still[i]) normal[i].setZero();
  const auto add = [&](const std::vector<std::uint32_t>& triangles) {
    for (const std::uint32_t t : triangles) {
      const auto& [a, b, c] = face.triangles[t];
      const std::array<Vec3f, 3> corner = face::corner_normals(position[a], position[b], position[c]);
      normal[twin[a]] += corner[0];
      normal[twin[b]] += corner[1];
      normal[twin[c]] += corner[2];
    }
  };
  add(solid_triangle);
  add(clear_triangle);
  add(moving_hair_triangle);
  if (all) add(still_hair_triangle);
  for (std::size_t i = 0; i < normal.size(); ++i) {
    if (twin[i] != i || (is_still[i] && !all)) continue;
    const float length = normal[i].norm();
    normal[i] = length > 1e-20F ? Vec3f(normal[i] / length) : Vec3f::UnitZ();
    if (is_strand[i]) normal[i] = rounded_hair(position[i], normal[i], middle_m);
  }
  for (const std::uint32_t i : copied_vertex) normal[i] = normal[twin[i]];
  if (all)
    for (const std::uint32_t i : still_vertex) normal[i] = normal[twin[i]];

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

void Renderer::State::shade_by_hair() {
  if (hair_triangle.empty()) return;
  for (const std::vector<std::uint32_t>* list : {&lit_vertex, &moving_hair_vertex, &still_hair_vertex})
    parallel(workers, list->size(), 128, [&](std::size_t first, std::size_t last) {
      Asked asked;
      for (std::size_t at = first; at < last; ++at) {
        const std::uint32_t i = (*list)[at];
        const Vec3f from = position[i] + kScatterHeight_m * normal[i];
        // A ribbon is no shade to itself and its neighbours.
        const float near_m = is_strand[i] ? kOwnLock_m : 0;
        HairShade& shade = hair_shade[i];
        shade = {};
        if (!is_strand[i] || quality == Quality::still) {
          asked.clear();
          for (std::size_t k = 0; k < ambient_directions.size(); ++k)
            if (ambient_directions[k].dot(normal[i]) > kGrazing) asked.add(ambient_directions[k], k);
          asked.ask(hair, from, near_m, kAmbientReach_m);
          for (std::size_t k = 0; k < asked.count; ++k)
            shade.ambient[asked.index[k] / 32U] |= std::uint32_t{asked.blocked[k]} << asked.index[k] % 32U;
        }
        asked.clear();
        for (std::size_t l = 0; l < kLights; ++l)
          if (studio.light[l].direction.dot(normal[i]) >= kBehind)
            for (std::size_t k = 0; k < studio.light_samples[l].size(); ++k)
              asked.add(studio.light_samples[l][k], l * kMostLightSamples + k);
        asked.ask(hair, from, near_m, kFar_m);
        for (std::size_t a = 0; a < asked.count; ++a) {
          std::uint16_t& bits = shade.light[asked.index[a] / kMostLightSamples];
          bits = static_cast<std::uint16_t>(bits | asked.blocked[a] << asked.index[a] % kMostLightSamples);
        }
      }
    });
}

VertexLight Renderer::State::light_at(std::uint32_t i) const {
  const Vec3f& up = normal[i];
  const HairShade& shade = hair_shade[i];
  // Of hair, which has most vertices and blurs its own light, a film takes fewer directions.
  const bool fewer = is_strand[i] && quality == Quality::video;
  const std::size_t every = fewer ? 4 : 1, every_of_light = fewer ? 3 : 1;
  VertexLight arrives = VertexLight::Zero();
  Asked asked;
  float weights = 0, open_weights = 0;
  for (std::size_t k = 0; k < ambient_directions.size(); k += every)
    if (ambient_directions[k].dot(up) > kGrazing) asked.add(ambient_directions[k], k);
  asked.ask(solid, position[i] + kClear_m * up, 0, kAmbientReach_m);
  Vec3f light_sum = Vec3f::Zero();
  for (std::size_t a = 0; a < asked.count; ++a) {
    const std::size_t k = asked.index[a];
    const float cosine = asked.direction[a].dot(up);
    weights += cosine;
    if (asked.blocked[a] != 0) {
      light_sum += cosine * kBounce.cwiseProduct(around_direction[k]);
      continue;
    }
    open_weights += cosine;
    const bool in_hair = (shade.ambient[k / 32] >> k % 32 & 1U) != 0;
    light_sum += cosine * (in_hair ? kThroughHair : 1.0F) * around_direction[k];
  }
  if (weights > 0) arrives.head<3>() = (light_sum / weights).array();
  const float open = weights > 0 ? open_weights / weights : 0;
  // All lights at once: one question of many directions is cheaper than several of few.
  asked.clear();
  for (std::size_t l = 0; l < kLights; ++l)
    if (studio.light[l].direction.dot(up) >= kBehind)
      for (std::size_t k = 0; k < studio.light_samples[l].size(); k += every_of_light)
        asked.add(studio.light_samples[l][k], l * kMostLightSamples + k);
  asked.ask(solid, position[i] + kScatterHeight_m * up, 0, kFar_m);
  std::array<float, kLights> seen{}, of{};
  for (std::size_t a = 0; a < asked.count; ++a) {
    const std::size_t l = asked.index[a] / kMostLightSamples, k = asked.index[a] % kMostLightSamples;
    ++of[l];
    if (asked.blocked[a] == 0) seen[l] += (shade.light[l] >> k & 1U) != 0 ? kThroughHair : 1.0F;
  }
  for (std::size_t l = 0; l < kLights; ++l)
    if (of[l] > 0) {
      const float straight = seen[l] / of[l];
      arrives.segment<3>(3 * (1 + static_cast<Eigen::Index>(l))) =
          straight + (in_mouth[i] ? kAroundLips * open * (1 - straight) : 0.0F);
    }
  return arrives;
}

void Renderer::State::lend_to_covered() {
  const auto is_covered = [](const VertexLight& arrives) { return (arrives < kCoveredLight).all(); };
  for (int ring = 0; ring < kCoveredRings; ++ring) {
    scattered_next = scattered;
    for (std::size_t k = 0; k < lit_vertex.size(); ++k) {
      if ((spread_share[k] == 0).all() || !is_covered(scattered[k])) continue;
      VertexLight sum = VertexLight::Zero();
      int lit = 0;
      for (const std::uint32_t i : neighbours_of(k)) {
        if (is_covered(scattered[i])) continue;
        sum += scattered[i];
        ++lit;
      }
      if (lit > 0) scattered_next[k] = sum / static_cast<float>(lit);
    }
    scattered.swap(scattered_next);
  }
}

void Renderer::State::light_surfaces(const std::vector<std::uint32_t>& places) {
  std::vector<std::uint32_t> asked, between;
  std::vector<std::uint8_t> is_new(lit_vertex.size(), 0);
  for (const std::uint32_t k : places) is_new[k] = 1;
  for (const std::uint32_t k : places) {
    const bool from_around =
        !is_between.empty() && is_between[k] != 0 &&
        std::ranges::all_of(neighbours_of(k), [&](std::uint32_t i) { return is_new[i] != 0; });
    (from_around ? between : asked).push_back(k);
  }
  parallel(workers, asked.size(), 64, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) unscattered[asked[k]] = light_at(lit_vertex[asked[k]]);
  });
  for (const std::uint32_t k : between) {
    VertexLight sum = VertexLight::Zero();
    for (const std::uint32_t i : neighbours_of(k)) sum += unscattered[i];
    unscattered[k] = sum / static_cast<float>(neighbours_of(k).size());
  }
  scattered = unscattered;
  lend_to_covered();
  for (int step = 0; step < kScatterSteps; ++step) {
    parallel(workers, lit_vertex.size(), 1024, [&](std::size_t first, std::size_t last) {
      for (std::size_t k = first; k < last; ++k) {
        scattered_next[k] = scattered[k];
        const std::span<const std::uint32_t> around = neighbours_of(k);
        if (around.empty()) continue;
        VertexLight mean = VertexLight::Zero();
        for (const std::uint32_t i : around) mean += scattered[i];
        mean /= static_cast<float>(around.size());
        scattered_next[k] += spread_share[k] * (mean - scattered[k]);
      }
    });
    scattered.swap(scattered_next);
  }
  for (std::size_t k = 0; k < lit_vertex.size(); ++k) light[lit_vertex[k]] = scattered[k];
}

void Renderer::State::light_hair(const std::vector<std::uint32_t>& vertices) {
  parallel(workers, vertices.size(), 128, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) light[vertices[k]] = light_at(vertices[k]);
  });
}

void Renderer::State::light_rest() {
  pose(face.neutral_m, true);
  shade_by_hair();
  light_hair(still_hair_vertex);
  light_hair(moving_hair_vertex);
  light_surfaces(every_place);
  copy_light(true);
  rest.unscattered = unscattered;
  rest.light = light;
  rest.normal = normal;
  rest.folds = folds;
  rest.triangles_in_tile.clear();
  for (std::size_t tile = 0; tile < solid_bins.count(); ++tile)
    rest.triangles_in_tile.push_back(triangles_in(tile));
}

void Renderer::State::find_vertices_between() {
  is_between.assign(lit_vertex.size(), 0);
  for (std::size_t k = 0; k < lit_vertex.size(); ++k) {
    const std::span<const std::uint32_t> around = neighbours_of(k);
    const std::uint32_t own = lit_vertex[k];
    const bool smooth = std::ranges::all_of(around, [&](std::uint32_t i) {
      const std::uint32_t other = lit_vertex[i];
      return is_between[i] == 0 && (face.neutral_m[own] - face.neutral_m[other]).norm() < kBetween_m &&
             normal[own].normalized().dot(normal[other].normalized()) > kBetweenNormal;
    });
    is_between[k] = smooth && around.size() >= 4 ? 1 : 0;
  }
}

std::size_t Renderer::State::triangles_in(std::size_t tile) const {
  return solid_bins.of(tile).size() + clear_bins.of(tile).size() + moving_hair_bins.of(tile).size() +
         still_hair_bins.of(tile).size();
}

std::vector<std::uint32_t> Renderer::State::places_to_light() const {
  std::vector<std::uint32_t> places;
  for (const std::uint32_t k : every_place) {
    const std::uint32_t i = lit_vertex[k];
    if (near_motion[i] && is_visible[i] != 0) places.push_back(k);
  }
  return places;
}

void Renderer::State::find_what_rests() {
  parallel(workers, rests.size(), 4096, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i)
      rests[i] = is_still[i] || (position[i] == face.neutral_m[i] && normal[i] == rest.normal[i] &&
                                 (light[i] == rest.light[i]).all() &&
                                 (folds.empty() || (folds[i] == rest.folds[i]).all()))
                     ? 1
                     : 0;
  });
}

void Renderer::State::see_what_moves() {
  tile_depths.resize(solid_bins.count());
  is_seen.assign(solid_bins.count(), 0);
  is_visible.assign(position.size(), 0);
  parallel(workers, tile_depths.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t tile = first; tile < last; ++tile) {
      const bool may_move = std::ranges::any_of(solid_bins.of(tile), [&](std::uint32_t t) {
        return std::ranges::any_of(face.triangles[t], [&](std::uint32_t i) { return near_motion[i]; });
      });
      if (!may_move) continue;
      is_seen[tile] = 1;
      see(tile, &tile_depths[tile]);
      std::uint32_t known = TileDepths::kNothing;
      for (const std::uint32_t t : tile_depths[tile].triangles()) {
        if (t == known || t == TileDepths::kNothing) continue;
        known = t;
        for (const std::uint32_t i : face.triangles[t])
          std::atomic_ref(is_visible[twin[i]]).store(1, std::memory_order_relaxed);
      }
    }
  });
}

void Renderer::State::see(std::size_t tile, TileDepths* depths) const {
  const auto across = static_cast<std::size_t>(tiles_in(view.width));
  depths->clear(static_cast<int>(tile % across) * kTile, static_cast<int>(tile / across) * kTile);
  // What faces the camera comes first: the back of the head is then hidden, which is quicker found than
  // drawn.
  std::vector<std::uint32_t> away;
  for (const std::uint32_t t : solid_bins.of(tile)) {
    const auto& [a, b, c] = face.triangles[t];
    if (faces_away(on_screen[a], on_screen[b], on_screen[c]))
      away.push_back(t);
    else
      depths->draw(t, ScreenTriangle(on_screen[a], on_screen[b], on_screen[c]));
  }
  depths->find_farthest();
  for (const std::uint32_t t : away) {
    const auto& [a, b, c] = face.triangles[t];
    if (!depths->hides(on_screen[a], on_screen[b], on_screen[c]))
      depths->draw(t, ScreenTriangle(on_screen[a], on_screen[b], on_screen[c]));
  }
}

bool Renderer::State::tile_rests(std::size_t tile) const {
  // What is at its place in the neutral was there then: as many as then are the same ones.
  if (!rest_is_lit || triangles_in(tile) != rest.triangles_in_tile[tile] || !clear_bins.of(tile).empty())
    return false;
  const auto all_rest = [&](std::span<const std::uint32_t> triangles) {
    return std::ranges::all_of(triangles, [&](std::uint32_t t) {
      const auto& [a, b, c] = face.triangles[t];
      return !is_eye(material[t]) && rests[a] != 0 && rests[b] != 0 && rests[c] != 0;
    });
  };
  return all_rest(solid_bins.of(tile)) && all_rest(moving_hair_bins.of(tile));
}

void Renderer::State::find_vertices_near_motion() {
  // Space is cut into cubes as large as the reach: a place is near if something moves in its own or one
  // beside it.
  using Cube = std::array<std::int32_t, 3>;
  const auto cube_of = [](const Vec3f& p) {
    const Vec3f q = (p / kNearMotion_m).array().floor();
    return Cube{static_cast<std::int32_t>(q.x()), static_cast<std::int32_t>(q.y()),
                static_cast<std::int32_t>(q.z())};
  };
  std::vector<Cube> moving;
  for (const face::Shape& shape : face.shapes)
    for (const std::uint32_t i : shape.vertex) moving.push_back(cube_of(face.neutral_m[i]));
  std::ranges::sort(moving);
  moving.erase(std::ranges::unique(moving).begin(), moving.end());
  near_motion.reserve(face.neutral_m.size());
  for (std::size_t i = 0; i < face.neutral_m.size(); ++i) {
    const Cube own = cube_of(face.neutral_m[i]);
    bool near = false;
    for (int k = 0; k < 27 && !near; ++k)
      near = std::ranges::binary_search(moving,
                                        Cube{own[0] + k % 3 - 1, own[1] + k / 3 % 3 - 1, own[2] + k / 9 - 1});
    near_motion.push_back(near);
  }
  for (std::uint32_t k = 0; k < lit_vertex.size(); ++k) every_place.push_back(k);
}

void Renderer::State::copy_light(bool all) {
  for (const std::uint32_t i : copied_vertex) light[i] = light[twin[i]];
  if (all)
    for (const std::uint32_t i : still_vertex) light[i] = light[twin[i]];
}

}  // namespace mien::render
