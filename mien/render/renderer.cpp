#include "mien/render/renderer.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <map>
#include <numbers>
#include <thread>
#include <utility>
#include <vector>

#include "mien/core/smoothstep.h"
#include "mien/render/error_colours.h"
#include "mien/render/parallel.h"
#include "mien/render/ray_scene.h"
#include "mien/render/solid_noise.h"
#include "mien/render/surface_paint.h"
#include "mien/render/tone.h"

namespace mien::render {
namespace {

using face::Material;
using Triangle = std::array<std::uint32_t, 3>;

constexpr float kPi = std::numbers::pi_v<float>;
constexpr std::size_t kLights = 3;
/// Rays start this far from the skin so that it does not block itself: well under a lid's thickness.
constexpr float kClear_m = 2e-4F;
/// Models put shells of an eyeball over each other; they must not shade each other either.
constexpr float kEyeClear_m = 8e-4F;
/// Rays to lights start higher above the skin: light enters some way from where it leaves, and the border of
/// shadow on a curved cheek is soft.
constexpr float kScatterHeight_m = 1.2e-3F;
/// Nothing of a head is further away than this.
constexpr float kFar_m = 0.5F;
/// What is nearer than this shades the light from everywhere.
constexpr float kAmbientReach_m = 0.07F;
/// How far light spreads in skin, red, green, blue: mean free paths of some millimetres and less
/// (Jensen et al. 2001, doi:10.1145/383259.383319, table 1), as the deviation of a Gaussian.
const Vec3f kScatter_m(3.4e-3F, 1.5e-3F, 0.9e-3F);
/// How far light wraps around the edge to the dark side, by channel.
const Vec3f kWrap(0.28F, 0.13F, 0.08F);

/// `count` directions spread evenly over the sphere (Fibonacci lattice).
std::vector<Vec3f> sphere_directions(int count) {
  std::vector<Vec3f> directions;
  for (int i = 0; i < count; ++i) {
    const float y = 1 - (2 * static_cast<float>(i) + 1) / static_cast<float>(count);
    const float r = std::sqrt(1 - y * y);
    const float turn = static_cast<float>(i) * kPi * (3 - std::sqrt(5.0F));
    directions.emplace_back(r * std::cos(turn), y, r * std::sin(turn));
  }
  return directions;
}

/// `count` directions evenly over a disc of `radius_rad` about `axis`.
std::vector<Vec3f> disc_directions(const Vec3f& axis, float radius_rad, int count) {
  const Vec3f side = axis.unitOrthogonal(), other = axis.cross(side);
  std::vector<Vec3f> directions;
  for (int i = 0; i < count; ++i) {
    const float r =
        std::tan(radius_rad) * std::sqrt((static_cast<float>(i) + 0.5F) / static_cast<float>(count));
    const float turn = static_cast<float>(i) * kPi * (3 - std::sqrt(5.0F));
    directions.push_back((axis + r * (std::cos(turn) * side + std::sin(turn) * other)).normalized());
  }
  return directions;
}

bool is_eye(Material material) {
  return material == Material::sclera || material == Material::iris || material == Material::pupil;
}

/// Fraction of mirrored light (Schlick 1994).
float fresnel(float reflectance, float cosine) {
  const float x = 1 - std::clamp(cosine, 0.0F, 1.0F);
  return reflectance + (1 - reflectance) * x * x * x * x * x;
}

/// GGX distribution times its visibility term. Source: Walter et al. 2007; visibility after Karis 2013.
float highlight(float n_h, float n_v, float n_l, float roughness) {
  const float a = roughness * roughness, a2 = a * a;
  const float d = n_h * n_h * (a2 - 1) + 1;
  const float k = 0.5F * a;
  const float visible = 0.25F / ((n_v * (1 - k) + k) * (n_l * (1 - k) + k));
  return a2 / (kPi * d * d) * visible;
}

/// Lights as one picture sees them, frame H.
struct Studio {
  std::array<Look::Light, kLights> light;
  std::array<std::vector<Vec3f>, kLights> light_samples;
  Vec3f sky, ground;

  /// Light that comes from a direction where nothing stands in the way.
  [[nodiscard]] Vec3f around(const Vec3f& direction) const {
    return mix(ground, sky, smoothstep(-0.9F, 0.9F, direction.y()));
  }
};

}  // namespace

Look Look::dark() {
  Look look;
  look.key = {Vec3f(-0.55F, 0.62F, 0.72F).normalized(), Vec3f(2.65F, 2.42F, 2.2F), 0.26F};
  look.fill = {Vec3f(0.85F, 0.10F, 0.55F).normalized(), Vec3f(0.30F, 0.36F, 0.46F), 0.40F};
  look.rim = {Vec3f(0.75F, 0.45F, -0.62F).normalized(), Vec3f(1.5F, 1.65F, 1.9F), 0.22F};
  look.sky = Vec3f(0.30F, 0.32F, 0.36F);
  look.ground = Vec3f(0.10F, 0.075F, 0.065F);
  look.background_top = {38, 42, 50};
  look.background_bottom = {16, 18, 22};
  return look;
}

Look Look::light() {
  Look look = dark();
  look.key.radiance = Vec3f(2.3F, 2.15F, 2.0F);
  look.fill.radiance = Vec3f(0.45F, 0.48F, 0.52F);
  look.rim.radiance = Vec3f(0.9F, 0.95F, 1.0F);
  look.sky = Vec3f(0.52F, 0.54F, 0.57F);
  look.ground = Vec3f(0.24F, 0.21F, 0.195F);
  look.background_top = {244, 245, 247};
  look.background_bottom = {222, 225, 230};
  return look;
}

struct Renderer::State {
  State(const face::Face& f, Quality q, int thread_count)
      : face(f),
        quality(q),
        threads(thread_count > 0 ? thread_count
                                 : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))),
        paint(f),
        material(material_of_triangles(f)),
        layer(layer_of_triangles()),
        solid(f.neutral_m, pick_triangles(Layer::solid, &solid_triangle)),
        clear(f.neutral_m, pick_triangles(Layer::clear, &clear_triangle)),
        fringe(f.neutral_m, pick_triangles(Layer::fringe, &fringe_triangle)) {
    find_neighbours();
    measure_lashes();
    lowest_m = std::numeric_limits<float>::max();
    for (const Vec3f& p : f.neutral_m) lowest_m = std::min(lowest_m, p.y());
    ambient_directions = sphere_directions(q == Quality::still ? 96 : 40);
    eye_directions = sphere_directions(q == Quality::still ? 48 : 24);
  }

  static std::vector<Material> material_of_triangles(const face::Face& f) {
    std::vector<Material> all(f.triangles.size(), Material::skin);
    for (const face::Part& part : f.parts)
      for (std::size_t t = part.first_triangle; t < std::size_t{part.first_triangle} + part.triangle_count;
           ++t)
        if (t < all.size()) all[t] = part.material;
    return all;
  }

  /// Rays meet three meshes: what is solid and shades, what is clear, and lashes, which do neither.
  enum class Layer : std::uint8_t { solid, clear, fringe };

  [[nodiscard]] std::vector<Layer> layer_of_triangles() const {
    std::vector<Layer> all;
    for (const Material m : material)
      all.push_back(m == Material::cornea ? Layer::clear
                    : m == Material::lash ? Layer::fringe
                                          : Layer::solid);
    return all;
  }
  [[nodiscard]] std::vector<Triangle> pick_triangles(Layer wanted, std::vector<std::uint32_t>* index) const {
    std::vector<Triangle> picked;
    for (std::size_t t = 0; t < face.triangles.size(); ++t)
      if (layer[t] == wanted) {
        picked.push_back(face.triangles[t]);
        index->push_back(static_cast<std::uint32_t>(t));
      }
    return picked;
  }

  void find_neighbours();
  void measure_lashes();
  void find_normals(std::span<const Vec3f> vertices_m);
  void light_vertices(const Studio& studio);
  void scatter_light();
  [[nodiscard]] Vec3f shade(const Studio& studio, const Vec3f& origin, const Vec3f& direction,
                            const ErrorColours* errors, float footprint_m, float* cover) const;
  [[nodiscard]] Vec3f shade_eye(const Studio& studio, const Vec3f& p, Vec3f n, const Vec3f& to_camera,
                                const Surface& surface, const Vec3f& neutral, bool painted) const;
  [[nodiscard]] Vec3f mirrored(const Studio& studio, const Vec3f& p, const Vec3f& n, const Vec3f& to_camera,
                               float sharpness) const;

  const face::Face& face;
  Quality quality;
  int threads;
  SurfacePaint paint;
  std::vector<Material> material;  // A triangle.
  std::vector<Layer> layer;
  std::vector<std::uint32_t> solid_triangle, clear_triangle, fringe_triangle;  // Index in the face.
  RayScene solid, clear, fringe;
  std::vector<std::uint32_t> neighbour_start, neighbour;  // Vertices that share an edge.
  std::vector<std::uint32_t> twin;   // The first vertex at the same place with about the same normal.
  std::vector<float> spread_m;       // Mean edge length at each vertex.
  std::vector<bool> lit_by_vertex;   // Neither eye nor clear.
  std::vector<float> lash_length_m;  // From the lid; 0 elsewhere.
  float lowest_m = 0;
  std::vector<Vec3f> ambient_directions, eye_directions;

  // Of the picture at work.
  std::vector<Vec3f> position, normal;
  std::vector<Vec3f> ambient;                       // Light from everywhere that arrives, over pi.
  std::array<std::vector<Vec3f>, kLights> visible;  // Part of each light that arrives, by channel.
  std::array<Eigen::Matrix3f, 2> eye_turn;
};

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
  for (std::size_t t = 0; t < face.triangles.size(); ++t) {
    if (is_eye(material[t]) || layer[t] != Layer::solid) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t a = twin[face.triangles[t][c]], b = twin[face.triangles[t][(c + 1) % 3]];
      lit_by_vertex[a] = true;
      if (a == b) continue;
      edges.emplace_back(a, b);
      edges.emplace_back(b, a);
    }
  }
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
    for (const std::uint32_t i : face.triangles[t]) (layer[t] == Layer::fringe ? is_lash : is_skin)[i] = true;
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
  parallel(threads, n, 256, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (twin[i] != i || !lit_by_vertex[i]) continue;
      const Vec3f& up = normal[i];
      float weights = 0;
      Vec3f light = Vec3f::Zero();
      for (const Vec3f& d : ambient_directions) {
        const float cosine = d.dot(up);
        if (cosine <= 0.02F) continue;
        weights += cosine;
        if (!solid.blocked(position[i] + kClear_m * up, d, 0, kAmbientReach_m))
          light += cosine * studio.around(d);
      }
      if (weights > 0) ambient[i] = light / weights;
      for (std::size_t l = 0; l < kLights; ++l) {
        if (studio.light[l].direction.dot(up) < -0.45F) continue;
        int seen = 0;
        for (const Vec3f& d : studio.light_samples[l])
          if (!solid.blocked(position[i] + kScatterHeight_m * up, d, 0, kFar_m)) ++seen;
        visible[l][i].setConstant(static_cast<float>(seen) /
                                  static_cast<float>(studio.light_samples[l].size()));
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
          const Vec3f lambda = (scatter_m.cwiseProduct(scatter_m) / variance).cwiseMin(0.6F);
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

Vec3f Renderer::State::mirrored(const Studio& studio, const Vec3f& p, const Vec3f& n, const Vec3f& to_camera,
                                float sharpness) const {
  const Vec3f out = (2 * n.dot(to_camera) * n - to_camera).normalized();
  Vec3f light = 0.35F * studio.around(out);
  for (const Look::Light& l : studio.light) {
    const float angle = std::acos(std::clamp(out.dot(l.direction), -1.0F, 1.0F));
    const float inside =
        1 - smoothstep((1 - sharpness) * l.radius_rad, (1 + sharpness) * l.radius_rad, angle);
    // A disc of this radius that lights a wall to `radiance` is brighter the smaller it is.
    if (inside > 0)
      light += inside * l.radiance / std::max(0.02F, std::sin(l.radius_rad) * std::sin(l.radius_rad));
  }
  if (solid.blocked(p + kEyeClear_m * n, out, 0, kAmbientReach_m)) light *= 0.08F;
  return fresnel(0.025F, n.dot(to_camera)) * light;
}

Vec3f Renderer::State::shade_eye(const Studio& studio, const Vec3f& p, Vec3f n, const Vec3f& to_camera,
                                 const Surface& surface, const Vec3f& neutral, bool painted) const {
  Vec3f light = Vec3f::Zero();
  float weights = 0;
  for (const Vec3f& d : eye_directions) {
    const float cosine = d.dot(n);
    if (cosine <= 0.02F) continue;
    weights += cosine;
    if (!solid.blocked(p + kEyeClear_m * n, d, 0, kAmbientReach_m)) light += cosine * studio.around(d);
  }
  if (weights > 0) light /= weights;
  for (std::size_t l = 0; l < kLights; ++l) {
    // Light also enters beside the point, so the ball's own edge of shadow is soft.
    const float facing = std::max(0.0F, (studio.light[l].direction.dot(n) + 0.2F) / 1.44F);
    if (facing <= 0) continue;
    int seen = 0;
    for (const Vec3f& d : studio.light_samples[l])
      if (!solid.blocked(p + kEyeClear_m * n, d, 0, kFar_m)) ++seen;
    light += facing * static_cast<float>(seen) / static_cast<float>(studio.light_samples[l].size()) *
             studio.light[l].radiance / kPi;
  }
  Vec3f out = surface.albedo.cwiseProduct(light);

  // The cornea is a smaller sphere that stands out of the ball: its normals turn faster.
  Vec3f wet = n;
  if (painted) {
    for (int e = 0; e < 2; ++e) {
      const face::Eyeball& ball = face.eyes[static_cast<std::size_t>(e)];
      if (ball.vertex_count == 0 || (neutral - ball.centre_m).norm() > 0.03F) continue;
      const Vec3f axis = eye_turn[static_cast<std::size_t>(e)] * paint.eye_axis(e);
      const float angle = std::acos(std::clamp(n.dot(axis), -1.0F, 1.0F));
      const float bulge = 1 - smoothstep(0.85F, 1.15F, angle / paint.iris_angle_rad(e));
      wet = (n - 0.40F * bulge * axis).normalized();
    }
  }
  out += mirrored(studio, p, wet, to_camera, 0.12F);
  return out;
}

Vec3f Renderer::State::shade(const Studio& studio, const Vec3f& origin, const Vec3f& direction,
                             const ErrorColours* errors, float footprint_m, float* cover) const {
  *cover = 0;
  const RayScene::Hit hit = solid.first_hit(origin, direction);
  const RayScene::Hit glass = clear.first_hit(origin, direction);
  if (!hit.any()) return Vec3f::Zero();

  const std::uint32_t triangle = solid_triangle[hit.triangle];
  const auto& [a, b, c] = face.triangles[triangle];
  const float wa = 1 - hit.u - hit.v;
  const auto between = [&](const auto& field) -> Vec3f {
    return wa * field[a] + hit.u * field[b] + hit.v * field[c];
  };
  const Vec3f p = origin + hit.distance * direction;
  const auto of_eyeball = [&](std::uint32_t i) {
    return std::ranges::any_of(face.eyes, [&](const face::Eyeball& ball) {
      return i >= ball.first_vertex && i < ball.first_vertex + ball.vertex_count;
    });
  };
  const Vec3f to_camera = -direction;
  Vec3f n = between(normal).normalized();
  if (n.dot(to_camera) < 0) n = (n - 1.02F * n.dot(to_camera) * to_camera).normalized();
  const Vec3f neutral = between(face.neutral_m);
  // A bust ends softly instead of with a cut.
  *cover = smoothstep(lowest_m + 0.002F, lowest_m + 0.05F, neutral.y());

  Vec3f own_colour = Vec3f::Zero();
  const bool has_colour = !face.colour.empty();
  if (has_colour) own_colour = between(face.colour);
  Surface surface = paint.at(neutral, material[triangle], has_colour ? &own_colour : nullptr);

  const bool glazed = glass.any() && glass.distance < hit.distance;
  const bool is_cornea = glazed && of_eyeball(face.triangles[clear_triangle[glass.triangle]][0]);
  Vec3f out = Vec3f::Zero();
  if (is_eye(material[triangle])) {
    out = shade_eye(studio, p, n, to_camera, surface, neutral, !(glazed && is_cornea));
  } else {
    const Vec3f light_here = between(ambient);
    std::array<Vec3f, kLights> seen;
    for (std::size_t l = 0; l < kLights; ++l) seen[l] = between(visible[l]);

    if (errors != nullptr) {
      const auto& e = errors->error_m;
      const float error_m = wa * e[a] + hit.u * e[b] + hit.v * e[c];
      surface.albedo = error_colour(error_m / errors->full_scale_m);
      surface.reflectance = 0.01F;
      surface.roughness = 0.7F;
      surface.scatter = 0.3F;
      surface.bump = 0;
    }
    // Pores, where a pixel is small enough to show them.
    Vec3f rough_n = n;
    const float pores = surface.bump * (1 - smoothstep(0.5e-3F, 1.1e-3F, footprint_m));
    if (pores > 0) {
      const Vec3f q = neutral * 900.0F;
      const Vec3f tilt(solid_noise(q), solid_noise(q + Vec3f(31, 7, 3)), solid_noise(q + Vec3f(5, 47, 19)));
      rough_n = (n + 0.10F * pores * tilt).normalized();
    }

    Vec3f diffuse = light_here;
    Vec3f shine = Vec3f::Zero();
    const float n_v = std::max(0.05F, rough_n.dot(to_camera));
    for (std::size_t l = 0; l < kLights; ++l) {
      const Look::Light& light = studio.light[l];
      const float facing = mix(n, rough_n, 0.35F).dot(light.direction);
      const Vec3f wrap = surface.scatter * kWrap;
      const Vec3f wrapped = ((Vec3f::Constant(facing) + wrap).array() /
                             (Vec3f::Ones() + wrap).array().square().matrix().array())
                                .cwiseMax(0.0F);
      diffuse += wrapped.cwiseProduct(seen[l]).cwiseProduct(light.radiance) / kPi;

      const float n_l = rough_n.dot(light.direction);
      if (n_l <= 0) continue;
      const Vec3f half = (light.direction + to_camera).normalized();
      const float n_h = std::clamp(rough_n.dot(half), 0.0F, 1.0F);
      // A wide light widens its highlight; two lobes: skin, and the oil on it.
      const float wide = 0.35F * light.radius_rad;
      const float lobes = 0.8F * highlight(n_h, n_v, n_l, std::min(1.0F, surface.roughness + wide)) +
                          0.2F * highlight(n_h, n_v, n_l, std::min(1.0F, 0.6F * surface.roughness + wide));
      shine += fresnel(surface.reflectance, half.dot(to_camera)) * lobes * n_l * seen[l].z() * light.radiance;
    }
    const Vec3f bounced = 2 * rough_n.dot(to_camera) * rough_n - to_camera;
    const float open = light_here.y() / std::max(1e-4F, studio.around(n).y());
    shine += 0.8F * fresnel(surface.reflectance, n_v) * (1 - 0.6F * surface.roughness) * open *
             studio.around(bounced);
    out = surface.albedo.cwiseProduct(diffuse) + shine;
  }

  if (errors != nullptr) return out;
  if (glazed) {
    const auto& [ga, gb, gc] = face.triangles[clear_triangle[glass.triangle]];
    const Vec3f gn =
        ((1 - glass.u - glass.v) * normal[ga] + glass.u * normal[gb] + glass.v * normal[gc]).normalized();
    // Tears along the lids and over the corners glisten less than the ball itself.
    const float strength = is_cornea ? 1.0F : 0.25F;
    if (gn.dot(to_camera) > 0)
      out += strength * mirrored(studio, origin + glass.distance * direction, gn, to_camera, 0.12F);
  }

  float from = 0, through = 1;
  for (int layers = 0; layers < 3; ++layers) {
    const RayScene::Hit lash = fringe.first_hit(origin, direction, from);
    if (!lash.any() || lash.distance > hit.distance) break;
    from = lash.distance + 1e-5F;
    const auto& corner = face.triangles[fringe_triangle[lash.triangle]];
    const std::array<float, 3> weight = {1 - lash.u - lash.v, lash.u, lash.v};
    Vec3f place = Vec3f::Zero();
    float length_m = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      place += weight[k] * face.neutral_m[corner[k]];
      length_m += weight[k] * lash_length_m[corner[k]];
    }
    through *= 1 - paint.lash_cover(place, length_m);
  }
  return mix(Vec3f(0.012F, 0.009F, 0.008F), out, through);
}

Renderer::Renderer(const face::Face& face, Quality quality, int threads)
    : state_(std::make_unique<State>(face, quality, threads)) {}
Renderer::~Renderer() = default;

Image Renderer::still(std::span<const Vec3f> vertices_m, const Camera& camera, const Look& look,
                      const ErrorColours* errors) {
  State& s = *state_;
  assert(vertices_m.size() == s.face.neutral_m.size());
  assert(errors == nullptr || errors->error_m.size() == vertices_m.size());
  assert(camera.width > 0 && camera.height > 0);

  const Vec3f forward = (camera.target_m - camera.position_m).normalized();
  const Vec3f right = forward.cross(camera.up).normalized();
  const Vec3f up = right.cross(forward);

  Studio studio;
  studio.light = {look.key, look.fill, look.rim};
  for (std::size_t l = 0; l < kLights; ++l) {
    const Vec3f d = studio.light[l].direction;
    studio.light[l].direction = (d.x() * right + d.y() * up - d.z() * forward).normalized();
    studio.light_samples[l] = disc_directions(studio.light[l].direction, studio.light[l].radius_rad,
                                              s.quality == Quality::still ? 16 : 6);
  }
  studio.sky = look.sky;
  studio.ground = look.ground;

  s.find_normals(vertices_m);
  s.solid.move(vertices_m);
  s.clear.move(vertices_m);
  s.fringe.move(vertices_m);
  s.light_vertices(studio);
  s.scatter_light();

  Image picture(camera.width, camera.height);
  const float half_height = std::tan(0.5F * camera.field_of_view_rad);
  const float pixel = 2 * half_height / static_cast<float>(camera.height);
  const float footprint_m = pixel * (camera.target_m - camera.position_m).norm();
  const Vec3f top = from_srgb(look.background_top), bottom = from_srgb(look.background_bottom);
  const int grid = s.quality == Quality::still ? 3 : 2;
  const int edge_grid = grid + 2;

  const auto background = [&](float x, float y) {
    const float u = x / static_cast<float>(camera.width) - 0.5F, v = y / static_cast<float>(camera.height);
    return Vec3f(mix(top, bottom, smoothstep(0, 1, v)) * (1 - 0.5F * u * u));
  };
  // What a pixel shows is averaged after the tone curve, so that bright edges stay smooth.
  const auto sample = [&](float x, float y) {
    const Vec3f direction = (forward + ((x - 0.5F * static_cast<float>(camera.width)) * right -
                                        (y - 0.5F * static_cast<float>(camera.height)) * up) *
                                           pixel)
                                .normalized();
    float cover = 0;
    const Vec3f light = s.shade(studio, camera.position_m, direction, errors, footprint_m, &cover);
    const Vec3f behind = background(x, y);
    return cover > 0 ? mix(behind, tone_map(light), cover) : behind;
  };
  const auto average = [&](int px, int py, int n, float* contrast) {
    Vec3f sum = Vec3f::Zero(), low = Vec3f::Constant(1e9F), high = Vec3f::Constant(-1e9F);
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        // A slanted grid meets near-vertical and near-horizontal edges at different places.
        const float slant = 0.35F / static_cast<float>(n);
        const float x = (static_cast<float>(i) + 0.5F + slant * (static_cast<float>(2 * j + 1 - n))) /
                        static_cast<float>(n);
        const float y = (static_cast<float>(j) + 0.5F - slant * (static_cast<float>(2 * i + 1 - n))) /
                        static_cast<float>(n);
        const Vec3f value = sample(static_cast<float>(px) + x, static_cast<float>(py) + y);
        sum += value;
        low = low.cwiseMin(value);
        high = high.cwiseMax(value);
      }
    *contrast = (high - low).maxCoeff();
    return Vec3f(sum / static_cast<float>(n * n));
  };
  parallel(s.threads, static_cast<std::size_t>(camera.height), 4, [&](std::size_t first, std::size_t last) {
    for (auto y = static_cast<int>(first); y < static_cast<int>(last); ++y)
      for (int x = 0; x < camera.width; ++x) {
        float contrast = 0;
        Vec3f value = average(x, y, grid, &contrast);
        if (contrast > 0.06F) value = average(x, y, edge_grid, &contrast);
        const Rgb colour = to_srgb(value);
        std::ranges::copy(colour, picture.pixel(x, y));
      }
  });
  if (errors != nullptr) {
    const float brightness = bottom.mean();
    draw_error_legend(picture, errors->full_scale_m,
                      brightness > 0.3F ? Rgb{40, 42, 48} : Rgb{214, 217, 224});
  }
  return picture;
}

}  // namespace mien::render
