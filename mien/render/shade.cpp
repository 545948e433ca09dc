#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mien/render/renderer_state.h"
#include "mien/render/solid_noise.h"
#include "mien/render/strands.h"

namespace mien::render {
namespace {

/// Models put shells of an eyeball over each other; they must not shade each other either.
constexpr float kEyeClear_m = 8e-4F;
/// How far light wraps around the edge to the dark side, by channel.
const Vec3f kWrap(0.28F, 0.13F, 0.08F);

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

/// Of hair in front of each other this many are drawn, and no more once less than this comes through.
constexpr int kLayers = 16;
constexpr float kOpaque = 0.03F;
const Vec3f kLash(0.012F, 0.009F, 0.008F);
const Vec3f kHairColour(0.055F, 0.035F, 0.025F);

/// A place on a hair. Unit vectors, frame H.
struct HairPoint {
  Vec3f along, normal, albedo, ambient;
  std::array<float, kLights> visible;
};

/// Light that a hair throws back: diffuse about it, a white highlight shifted to its root and one of its own
/// colour shifted to its tip. Source: Kajiya and Kay 1989, doi:10.1145/74334.74361; the shifts after
/// Scheuermann 2004, "Practical real-time hair rendering and shading". Strengths chosen by eye.
Vec3f shade_hair(const Studio& studio, const HairPoint& at, const Vec3f& to_camera) {
  const auto lobe = [](const Vec3f& along, const Vec3f& half, float exponent) {
    const float cosine = along.dot(half);
    return std::pow(std::sqrt(std::max(0.0F, 1 - cosine * cosine)), exponent);
  };
  Vec3f out = at.albedo.cwiseProduct(at.ambient);
  const Vec3f to_root = (at.along + 0.06F * at.normal).normalized();
  const Vec3f to_tip = (at.along - 0.12F * at.normal).normalized();
  for (std::size_t l = 0; l < kLights; ++l) {
    const Look::Light& light = studio.light[l];
    if (at.visible[l] <= 0) continue;
    const float cosine = at.along.dot(light.direction);
    const float around = std::sqrt(std::max(0.0F, 1 - cosine * cosine));
    const float facing = std::clamp((at.normal.dot(light.direction) + 0.35F) / 1.35F, 0.0F, 1.0F);
    const Vec3f half = (light.direction + to_camera).normalized();
    const Vec3f colour = at.albedo * (0.35F + 0.65F * around) +
                         Vec3f::Constant(0.05F * lobe(to_root, half, 110)) +
                         at.albedo.cwiseSqrt() * (0.16F * lobe(to_tip, half, 22));
    out += at.visible[l] * facing * colour.cwiseProduct(light.radiance) / kPi;
  }
  return out;
}

}  // namespace

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

Vec3f Renderer::State::shade_fringe(const Studio& studio, const Vec3f& origin, const Vec3f& direction,
                                    float distance, bool in_error_colours, float footprint_m,
                                    float* through) const {
  Vec3f light = Vec3f::Zero();
  float from = 0;
  const int most = quality == Quality::still ? kLayers : kLayers / 2;
  for (int layers = 0; layers < most && *through >= kOpaque; ++layers) {
    const RayScene::Hit hit = fringe.first_hit(origin, direction, from);
    if (!hit.any() || hit.distance > distance) break;
    from = hit.distance + 1e-5F;
    const std::uint32_t triangle = fringe_triangle[hit.triangle];
    const Triangle& corner = face.triangles[triangle];
    const std::array<float, 3> weight = {1 - hit.u - hit.v, hit.u, hit.v};
    const auto between = [&](const auto& field) -> Vec3f {
      return weight[0] * field[corner[0]] + weight[1] * field[corner[1]] + weight[2] * field[corner[2]];
    };
    if (material[triangle] == Material::lash) {
      float length_m = 0;
      for (std::size_t k = 0; k < 3; ++k) length_m += weight[k] * lash_length_m[corner[k]];
      const float cover = paint.lash_cover(between(face.neutral_m), length_m);
      light += *through * cover * kLash;
      *through *= 1 - cover;
      continue;
    }
    if (face.uv.empty()) continue;
    // Along a hair and across the ribbon, from how uv lies on the triangle.
    const auto uv = [&](std::size_t k) -> const Eigen::Vector2f& { return face.uv[corner[k]]; };
    const Eigen::Vector2f d1 = uv(1) - uv(0), d2 = uv(2) - uv(0);
    const float det = d1.x() * d2.y() - d1.y() * d2.x();
    if (std::abs(det) < 1e-12F) continue;
    const Vec3f e1 = position[corner[1]] - position[corner[0]],
                e2 = position[corner[2]] - position[corner[0]];
    const Vec3f across = (d2.y() * e1 - d1.y() * e2) / det, along = (d1.x() * e2 - d2.x() * e1) / det;
    const float hair_m = across.norm() / face::kStrandsPerUv;
    const float softness = std::clamp(0.3F * footprint_m / std::max(hair_m, 1e-6F), 0.1F, 0.5F);
    const Eigen::Vector2f at = weight[0] * uv(0) + weight[1] * uv(1) + weight[2] * uv(2);
    const Strand strand = strand_at(at, softness);
    if (strand.cover <= 0) continue;
    HairPoint point{.along = along.normalized(),
                    .normal = between(normal).normalized(),
                    .albedo = face.colour.empty() ? Vec3f(kHairColour) : between(face.colour),
                    .ambient = between(ambient),
                    .visible = {}};
    point.albedo *= strand.brightness;
    if (in_error_colours) point.albedo = 0.4F * error_colour(0);
    for (std::size_t l = 0; l < kLights; ++l) point.visible[l] = between(visible[l]).y();
    light += *through * strand.cover * shade_hair(studio, point, -direction);
    *through *= 1 - strand.cover;
  }
  if (*through < kOpaque) {
    light /= 1 - *through;
    *through = 0;
  }
  return light;
}

Vec3f Renderer::State::shade(const Studio& studio, const Vec3f& origin, const Vec3f& direction,
                             const ErrorColours* errors, float footprint_m, float* cover) const {
  *cover = 0;
  const RayScene::Hit hit = solid.first_hit(origin, direction);
  float through = 1;
  const Vec3f before =
      shade_fringe(studio, origin, direction, hit.distance, errors != nullptr, footprint_m, &through);
  if (!hit.any() || through < kOpaque) {
    *cover = 1 - through;
    return through < 1 ? Vec3f(before / (1 - through)) : Vec3f(Vec3f::Zero());
  }

  const RayScene::Hit glass = clear.first_hit(origin, direction);
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
    const auto tilt = [&](float per_m, float strength) {
      const float seen_of_it = surface.bump * (1 - smoothstep(0.4F / per_m, 1.0F / per_m, footprint_m));
      if (seen_of_it <= 0) return;
      const Vec3f q = neutral * per_m;
      rough_n += strength * seen_of_it *
                 Vec3f(solid_noise(q), solid_noise(q + Vec3f(31, 7, 3)), solid_noise(q + Vec3f(5, 47, 19)));
    };
    tilt(450, 0.05F);
    tilt(900, 0.11F);
    tilt(2100, 0.15F);
    rough_n.normalize();

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
    // Of a rough surface little is mirrored even at its edge (Lagarde 2011's roughness-aware Fresnel term).
    const float edge = std::pow(1 - n_v, 5.0F);
    const float mirrors =
        surface.reflectance +
        (std::max(1 - surface.roughness, surface.reflectance) - surface.reflectance) * 0.35F * edge;
    shine += 0.8F * mirrors * (1 - 0.6F * surface.roughness) * open * studio.around(bounced);
    out = surface.albedo.cwiseProduct(diffuse) + shine;
  }

  if (errors != nullptr) return before + through * out;
  if (glazed) {
    const auto& [ga, gb, gc] = face.triangles[clear_triangle[glass.triangle]];
    const Vec3f gn =
        ((1 - glass.u - glass.v) * normal[ga] + glass.u * normal[gb] + glass.v * normal[gc]).normalized();
    // Tears along the lids and over the corners glisten less than the ball itself.
    const float strength = is_cornea ? 1.0F : 0.25F;
    if (gn.dot(to_camera) > 0)
      out += strength * mirrored(studio, origin + glass.distance * direction, gn, to_camera, 0.12F);
  }

  return before + through * out;
}

}  // namespace mien::render
