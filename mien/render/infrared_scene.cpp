#include "mien/render/infrared_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "mien/render/infrared_state.h"
#include "mien/render/solid_noise.h"
#include "mien/render/surface_paint.h"

namespace mien::render {
namespace {

using face::Material;

/// Albedos stand so far apart.
constexpr float kTexel_m = 0.5e-3F;
constexpr float kMostSteps = 12;
/// Rays of light end so far before the vertex that they are asked for, so that it does not shade itself.
constexpr float kShort_m = 1.2e-3F;
/// Rays are sent to a lamp that gives at least this share of all that falls at a place; less arrives as the
/// others' does, on average.
constexpr float kFaint = 0.1F;
/// Normals turn from vertex to vertex: light that comes from so far behind one (cosine) still reaches some of
/// its triangles, and a camera so far behind it (distance times cosine) sees some.
constexpr float kTurned = 0.2F, kTurnedAway_m = 0.012F;
/// Vertices so far outside of a picture belong to triangles that reach into it, shares of its width.
constexpr float kMargin = 0.06F;
/// Light that faces throw onto themselves and into the mouth: share of the mean of what falls on them.
constexpr float kThrownBack = 0.06F;
/// Of the light from everywhere, what a place gets that no lamp reaches.
constexpr float kCovered = 0.25F;
/// A face that moves by less between the first row and the last stands still.
constexpr float kStill_m = 15e-6F;

Gloss gloss_of(Material material) {
  switch (material) {
    case Material::lips:
      return Gloss::lips;
    case Material::teeth:
      return Gloss::teeth;
    case Material::gums:
    case Material::tongue:
    case Material::mouth_inside:
      return Gloss::wet;
    case Material::sclera:
    case Material::iris:
    case Material::pupil:
      return Gloss::eye;
    default:
      return Gloss::skin;
  }
}

bool is_solid(Material material) {
  return material != Material::strands && material != Material::cornea && material != Material::hair &&
         material != Material::lash;
}

/// How much of a place is hair, of a beard this dense: hairs hang down.
float beard_cover(const Vec3f& p, float amount) {
  if (amount <= 0) return 0;
  const float hairs = solid_noise(Vec3f(p.x() * 1100, p.y() * 260, p.z() * 1100)) +
                      0.5F * solid_noise(Vec3f(p.x() * 350, p.y() * 180, p.z() * 350));
  return std::clamp(1.3F * amount - 0.35F + 0.9F * hairs, 0.0F, 0.95F) * std::min(1.0F, 2 * amount);
}

bool is_in_picture(const Lens& lens, const ScreenPoint& point) {
  const float margin = kMargin * static_cast<float>(lens.width);
  const float x = static_cast<float>(point.x) / kSubpixels, y = static_cast<float>(point.y) / kSubpixels;
  return point.inverse_depth > 0 && x > -margin && y > -margin &&
         x < static_cast<float>(lens.width) + margin && y < static_cast<float>(lens.height) + margin;
}

/// Of a triangle whose sides have so many steps.
std::size_t texels_of(std::size_t steps) {
  return (steps + 1) * (steps + 2) / 2;
}

}  // namespace

InfraredScene::State::State(const face::Face& f, InfraredWearer w, std::span<const Vec3f> cameras_m,
                            float reach_m)
    : face(f), wearer(std::move(w)), solid({}, {}) {
  const auto is_near = [&](std::uint32_t v) {
    return std::ranges::any_of(cameras_m, [&](const Vec3f& camera_m) {
      return (face.neutral_m[v] - camera_m).squaredNorm() < reach_m * reach_m;
    });
  };
  constexpr std::uint32_t kLeftOut = ~0U;
  std::vector<std::uint32_t> local(face.neutral_m.size(), kLeftOut);
  const std::vector<Material> material = material_of_triangles(face);
  std::vector<std::uint32_t> of_face;
  for (std::uint32_t t = 0; t < face.triangles.size(); ++t) {
    if (!std::ranges::any_of(face.triangles[t], is_near)) continue;
    const bool strands = material[t] == Material::strands || material[t] == Material::lash;
    if (!is_solid(material[t]) && !strands) continue;
    std::array<std::uint32_t, 3> corners{};
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t v = face.triangles[t][c];
      if (local[v] == kLeftOut) {
        local[v] = static_cast<std::uint32_t>(kept.size());
        kept.push_back(v);
      }
      corners[c] = local[v];
    }
    if (strands) {
      strand.push_back(corners);
      continue;
    }
    Facet one{.gloss = gloss_of(material[t])};
    if (one.gloss == Gloss::eye)
      one.index = face.neutral_m[face.triangles[t][0]].x() > 0 ? std::uint8_t{0} : std::uint8_t{1};
    triangle.push_back(corners);
    facet.push_back(one);
    of_face.push_back(t);
  }
  for (std::size_t i = 0; i < kept.size(); ++i) {
    uv.push_back(face.uv.empty() ? Eigen::Vector2f::Zero().eval() : face.uv[kept[i]]);
    strand_albedo.push_back(face.colour.empty() ? 0.1F : face.colour[kept[i]].mean());
    first.push_back(face.neutral_m[kept[i]]);
  }
  bake(of_face);
  for (std::size_t k = 0; k < wearer.things.size(); ++k) {
    const InfraredThing& thing = wearer.things[k];
    const auto before = static_cast<std::uint32_t>(first.size());
    for (std::size_t i = 0; i < thing.vertices; ++i) {
      first.push_back(Vec3f(0, 0, -10));  // Until a pose says where.
      uv.push_back(Eigen::Vector2f::Zero());
      strand_albedo.push_back(thing.albedo);
    }
    for (const auto& [a, b, c] : thing.triangles) {
      triangle.push_back({before + a, before + b, before + c});
      Facet one{.gloss = Gloss::thing, .index = static_cast<std::uint8_t>(k), .two_sided = true};
      one.first_texel = static_cast<std::uint32_t>(texel.size());
      facet.push_back(one);
      texel.insert(texel.end(), texels_of(1), static_cast<std::uint8_t>(255 * thing.albedo));
    }
  }
  last = first;
  normal.resize(first.size());
  light.resize(first.size());
  solid = RayScene(first, triangle);
  first_m.assign(first);
  last_m.assign(last);
  find_shadow_vertices();
  find_normals();
  const SurfacePaint paint(face);
  neutral_axis = {paint.eye_axis(0), paint.eye_axis(1)};
  find_eyes(face.neutral_m, first_eyes);
  last_eyes = first_eyes;
}

void InfraredScene::State::bake(std::span<const std::uint32_t> of_face) {
  const SurfacePaint paint(face, wearer.marks);
  const std::vector<Material> material = material_of_triangles(face);
  for (std::size_t k = 0; k < of_face.size(); ++k) {
    const auto& [a, b, c] = face.triangles[of_face[k]];
    const float longest_m = std::max({(face.neutral_m[a] - face.neutral_m[b]).norm(),
                                      (face.neutral_m[b] - face.neutral_m[c]).norm(),
                                      (face.neutral_m[c] - face.neutral_m[a]).norm()});
    Facet& one = facet[k];
    one.first_texel = static_cast<std::uint32_t>(texel.size());
    if (one.gloss == Gloss::eye) {
      texel.insert(texel.end(), texels_of(1), 0);
      continue;
    }
    one.steps = static_cast<std::uint8_t>(std::clamp(std::ceil(longest_m / kTexel_m), 1.0F, kMostSteps));
    for (int i = 0; i <= one.steps; ++i)
      for (int j = 0; i + j <= one.steps; ++j) {
        const float second = static_cast<float>(i) / static_cast<float>(one.steps);
        const float third = static_cast<float>(j) / static_cast<float>(one.steps), w = 1 - second - third;
        const auto between = [&](const auto& field) {
          return (w * field[a] + second * field[b] + third * field[c]).eval();
        };
        const Vec3f place_m = between(face.neutral_m);
        Vec3f own = Vec3f::Zero();
        if (!face.colour.empty()) own = between(face.colour);
        Place place{.footprint_m = kTexel_m};
        if (!paint.marks().amount.empty()) place.marks = between(paint.marks().amount);
        const Material of = material[of_face[k]];
        float albedo = paint.at(place_m, of, face.colour.empty() ? nullptr : &own, place).albedo.mean();
        if (wearer.repaint) albedo = wearer.repaint(place_m, of, albedo);
        if (!wearer.beard.empty() && of == Material::skin) {
          const float amount = w * wearer.beard[a] + second * wearer.beard[b] + third * wearer.beard[c];
          albedo = std::lerp(albedo, wearer.beard_albedo, beard_cover(place_m, amount));
        }
        texel.push_back(static_cast<std::uint8_t>(std::lround(255 * std::clamp(albedo, 0.0F, 1.0F))));
      }
  }
}

void InfraredScene::State::Coordinates::assign(std::span<const Vec3f> places_m) {
  x.resize(places_m.size());
  y.resize(places_m.size());
  z.resize(places_m.size());
  for (std::size_t i = 0; i < places_m.size(); ++i) {
    x[i] = places_m[i].x();
    y[i] = places_m[i].y();
    z[i] = places_m[i].z();
  }
}

void InfraredScene::State::find_shadow_vertices() {
  std::vector<std::vector<std::uint32_t>> beside(first.size());
  const auto join = [&](const std::vector<std::array<std::uint32_t, 3>>& triangles) {
    for (const auto& corners : triangles)
      for (const std::uint32_t a : corners)
        for (const std::uint32_t b : corners)
          if (a != b) beside[a].push_back(b);
  };
  join(triangle);
  join(strand);
  is_strand.assign(first.size(), 0);
  for (const auto& corners : strand)
    for (const std::uint32_t v : corners) is_strand[v] = 1;
  // A maximal independent set, in the vertices' order.
  std::vector<std::uint8_t> is_told(first.size(), 0), tells(first.size(), 0);
  for (std::uint32_t v = 0; v < first.size(); ++v) {
    std::ranges::sort(beside[v]);
    beside[v].erase(std::unique(beside[v].begin(), beside[v].end()), beside[v].end());
    if (is_told[v] != 0) continue;
    tells[v] = 1;
    for (const std::uint32_t other : beside[v]) is_told[other] = 1;
  }
  for (std::uint32_t v = 0; v < first.size(); ++v) {
    shadow_start.push_back(static_cast<std::uint32_t>(shadow_of.size()));
    if (tells[v] != 0)
      shadow_of.push_back(v);
    else
      for (const std::uint32_t other : beside[v])
        if (tells[other] != 0) shadow_of.push_back(other);
  }
  shadow_start.push_back(static_cast<std::uint32_t>(shadow_of.size()));
}

void InfraredScene::State::find_normals() {
  std::ranges::fill(normal, Vec3f::Zero());
  for (const auto& [a, b, c] : triangle) {
    const Vec3f across = (first[b] - first[a]).cross(first[c] - first[a]);
    normal[a] += across;
    normal[b] += across;
    normal[c] += across;
  }
  for (const auto& [a, b, c] : strand)
    for (const std::uint32_t v : {a, b, c})
      normal[v] = (first[v] - Vec3f(0, first[v].y(), 0)).normalized();  // As the head's round shape.
  for (Vec3f& n : normal) {
    const float length = n.norm();
    if (length > 0) n /= length;
  }
}

void InfraredScene::State::find_eyes(std::span<const Vec3f> vertices_m, std::array<SeenEye, 2>& eyes) const {
  for (std::size_t e = 0; e < 2; ++e) {
    const face::Eyeball& ball = face.eyes[e];
    SeenEye& eye = eyes[e];
    eye.centre_m = ball.centre_m;
    if (ball.vertex_count == 0) continue;
    // A ball turns as a whole: two of its places tell how.
    Vec3f middle = Vec3f::Zero(), neutral_middle = Vec3f::Zero();
    float radius = 0;
    for (std::uint32_t v = ball.first_vertex; v < ball.first_vertex + ball.vertex_count; ++v) {
      const Vec3f rest = face.neutral_m[v] - ball.centre_m;
      radius += rest.norm();
      const float ahead = std::max(0.0F, rest.z() / std::max(rest.norm(), 1e-6F) - 0.8F);
      middle += ahead * (vertices_m[v] - ball.centre_m);
      neutral_middle += ahead * rest;
    }
    eye.radius_m = radius / static_cast<float>(ball.vertex_count);
    const Eigen::Quaternionf turn =
        Eigen::Quaternionf::FromTwoVectors(neutral_middle.normalized(), middle.normalized());
    eye.axis = turn * neutral_axis[e];
    eye.up = (Vec3f::UnitY() - Vec3f::UnitY().dot(eye.axis) * eye.axis).normalized();
  }
}

float InfraredScene::State::albedo(const Facet& one, float second, float third) const {
  const int n = one.steps;
  const int i = std::clamp(static_cast<int>(second * static_cast<float>(n) + 0.5F), 0, n);
  const int j = std::clamp(static_cast<int>(third * static_cast<float>(n) + 0.5F), 0, n - i);
  const int row = i * (n + 1) - i * (i - 1) / 2;
  return static_cast<float>(texel[one.first_texel + static_cast<std::uint32_t>(row + j)]) / 255;
}

InfraredScene::InfraredScene(const face::Face& face, InfraredWearer wearer, std::span<const Vec3f> cameras_m,
                             float reach_m)
    : state_(std::make_unique<State>(face, std::move(wearer), cameras_m, reach_m)) {}
InfraredScene::~InfraredScene() = default;
InfraredScene::InfraredScene(InfraredScene&&) noexcept = default;

void InfraredScene::pose(std::span<const Vec3f> first_m, std::span<const Vec3f> last_m,
                         std::span<const Vec3f> things_m) {
  State& s = *state_;
  float most2 = 0;
  for (std::size_t i = 0; i < s.kept.size(); ++i) {
    s.first[i] = first_m[s.kept[i]];
    s.last[i] = last_m[s.kept[i]];
    most2 = std::max(most2, (s.last[i] - s.first[i]).squaredNorm());
  }
  for (std::size_t i = 0; i < things_m.size(); ++i)
    s.first[s.kept.size() + i] = s.last[s.kept.size() + i] = things_m[i];
  s.moves = most2 > kStill_m * kStill_m;
  s.find_normals();
  s.find_eyes(first_m, s.first_eyes);
  s.find_eyes(last_m, s.last_eyes);
  s.solid.move(s.first);
  s.first_m.assign(s.first);
  s.last_m.assign(s.last);
}

void InfraredScene::set_pupils(const std::array<float, 2>& radius_m) {
  for (std::size_t e = 0; e < 2; ++e)
    state_->first_eyes[e].pupil_m = state_->last_eyes[e].pupil_m = radius_m[e];
}

void InfraredScene::State::ask_shadows(const Vec3f& lamp_m, std::span<const float> would_fall) {
  constexpr float kUnknown = -1, kAsked = -2;
  arriving.assign(first.size(), kUnknown);
  asked.clear();
  targets.clear();
  for (std::size_t k = 0; k < seen.size(); ++k)
    if (would_fall[k] > kFaint * light[seen[k]].ambient)
      for (const std::uint32_t v : shadows_of(seen[k]))
        if (arriving[v] == kUnknown) {
          if (is_strand[v] != 0) {  // Hair lets light through.
            arriving[v] = 1;
            continue;
          }
          arriving[v] = kAsked;
          asked.push_back(v);
          targets.push_back(first[v]);
        }
  is_blocked.resize(asked.size());
  solid.blocked_towards(lamp_m, targets, kShort_m, is_blocked);
  for (std::size_t i = 0; i < asked.size(); ++i) arriving[asked[i]] = is_blocked[i] == 0 ? 1.0F : 0.0F;
}

void InfraredScene::light(std::span<const InfraredLamp> lamps, float ambient, std::span<const Lens> seen_by) {
  State& s = *state_;
  s.lamps.assign(lamps.begin(), lamps.end());
  std::ranges::fill(s.light, FallingLight{});
  s.is_seen.assign(s.first.size(), 0);
  s.points.resize(s.first.size());
  for (const Lens& lens : seen_by) {
    lens.project(s.first_m.x, s.first_m.y, s.first_m.z, s.points);
    for (std::uint32_t v = 0; v < s.first.size(); ++v)
      if (is_in_picture(lens, s.points[v]) && s.normal[v].dot(lens.position_m - s.first[v]) > -kTurnedAway_m)
        s.is_seen[v] = 1;
  }
  s.seen.clear();
  for (std::uint32_t v = 0; v < s.first.size(); ++v)
    if (s.is_seen[v] != 0) s.seen.push_back(v);

  // What would fall without shadows, summed in `ambient` for now; then what does.
  s.falling.resize(lamps.size() * s.seen.size());
  const auto falling_of = [&](std::size_t l) {
    return std::span(s.falling).subspan(l * s.seen.size(), s.seen.size());
  };
  for (std::size_t l = 0; l < lamps.size(); ++l)
    for (std::size_t k = 0; k < s.seen.size(); ++k) {
      const std::uint32_t v = s.seen[k];
      const Vec3f way = lamps[l].position_m - s.first[v];
      const bool faces = s.normal[v].dot(way) > -kTurned * way.norm();
      s.light[v].ambient += falling_of(l)[k] = faces ? lamp_irradiance(lamps[l], s.first[v]) : 0;
    }
  s.asked_of.assign(s.seen.size(), 0.0F);
  s.arrived_of.assign(s.seen.size(), 0.0F);
  for (std::size_t l = 0; l < lamps.size(); ++l) {
    const std::span<const float> falling = falling_of(l);
    s.ask_shadows(lamps[l].position_m, falling);
    for (std::size_t k = 0; k < s.seen.size(); ++k) {
      const std::uint32_t v = s.seen[k];
      if (falling[k] <= kFaint * s.light[v].ambient) continue;
      float share = 0;
      const auto shadows = s.shadows_of(v);
      for (const std::uint32_t told : shadows) share += s.arriving[told];
      const float arrives = share / static_cast<float>(shadows.size()) * falling[k];
      s.asked_of[k] += falling[k];
      s.arrived_of[k] += arrives;
      if (arrives > 0) s.light[v].directed += arrives * (lamps[l].position_m - s.first[v]).normalized();
    }
  }
  for (std::size_t l = 0; l < lamps.size(); ++l)
    for (std::size_t k = 0; k < s.seen.size(); ++k) {
      const std::uint32_t v = s.seen[k];
      const float falling = falling_of(l)[k];
      if (falling <= 0 || falling > kFaint * s.light[v].ambient || s.arrived_of[k] <= 0) continue;
      s.light[v].directed +=
          falling * s.arrived_of[k] / s.asked_of[k] * (lamps[l].position_m - s.first[v]).normalized();
    }
  float mean = 0;
  for (const std::uint32_t v : s.seen) mean += s.light[v].directed.norm();
  mean /= static_cast<float>(std::max<std::size_t>(1, s.seen.size()));
  s.background_radiance = s.wearer.background * (mean + ambient) / std::numbers::pi_v<float>;
  for (const std::uint32_t v : s.seen) {
    FallingLight& one = s.light[v];
    const float open = one.ambient > 0 ? std::min(1.0F, one.directed.norm() / one.ambient) : 0.5F;
    one.ambient = (ambient + kThrownBack * mean) * (kCovered + (1 - kCovered) * open);
  }
}

}  // namespace mien::render
