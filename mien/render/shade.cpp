#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mien/render/renderer_state.h"
#include "mien/render/skin_detail.h"

namespace mien::render {
namespace {

/// Models put shells of an eyeball over each other; they must not shade each other either.
constexpr float kEyeClear_m = 8e-4F;
/// Where that is inside of a lid, which hugs the ball.
constexpr float kUnderLid_m = 1.5e-4F;
/// How far light wraps around the edge to the dark side, by channel.
const Vec3f kWrap(0.20F, 0.12F, 0.09F);

/// Light that has gone under the skin shows less of a fold than what the surface mirrors.
constexpr float kFoldsInDiffuse = 0.75F;
/// How much darker the bottom of a fold is for each unit of its slope.
const Vec3f kFoldShade(0.35F, 0.55F, 0.60F);

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

}  // namespace

Vec3f Renderer::State::mirrored(const Vec3f& p, const Vec3f& n, const Vec3f& to_camera,
                                float sharpness) const {
  const Vec3f out = (2 * n.dot(to_camera) * n - to_camera).normalized();
  Vec3f comes = 0.35F * studio.around(out);
  for (const Look::Light& l : studio.light) {
    const float angle = std::acos(std::clamp(out.dot(l.direction), -1.0F, 1.0F));
    const float inside =
        1 - smoothstep((1 - sharpness) * l.radius_rad, (1 + sharpness) * l.radius_rad, angle);
    // A disc of this radius that lights a wall to `radiance` is brighter the smaller it is; wide ones fade to
    // their edge, which would otherwise stand in the pupil like a hole.
    const float fades = std::min(1.0F, 0.26F / l.radius_rad);
    if (inside > 0)
      comes += fades * fades * inside * l.radiance /
               std::max(0.02F, std::sin(l.radius_rad) * std::sin(l.radius_rad));
  }
  if (solid.blocked(p + kEyeClear_m * n, out, 0, kAmbientReach_m)) comes *= 0.08F;
  return fresnel(0.025F, n.dot(to_camera)) * comes;
}

Vec3f Renderer::State::shade_eye(const Vec3f& p, Vec3f n, const Vec3f& to_camera, const Surface& surface,
                                 const Vec3f& neutral, bool painted) const {
  Vec3f from = p + kEyeClear_m * n;
  std::array<Vec3f, kMostDirections> asked;
  std::array<std::uint8_t, kMostDirections> blocked{};
  std::size_t count = 0;
  for (const Vec3f& d : eye_directions)
    if (d.dot(n) > kGrazing) asked[count++] = d;
  const auto ask = [&] {
    solid.blocked(from, std::span(asked).first(count), 0, kAmbientReach_m, std::span(blocked).first(count));
  };
  ask();
  const auto end = blocked.begin() + static_cast<std::ptrdiff_t>(count);
  if (2 * std::count(blocked.begin(), end, std::uint8_t{0}) < static_cast<std::ptrdiff_t>(count)) {
    from = p + kUnderLid_m * n;
    ask();
  }
  Vec3f arrives = Vec3f::Zero();
  float weights = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const float cosine = asked[k].dot(n);
    weights += cosine;
    if (blocked[k] == 0) arrives += cosine * studio.around(asked[k]);
  }
  if (weights > 0) arrives /= weights;
  for (std::size_t l = 0; l < kLights; ++l) {
    // Light also enters beside the point, so the ball's own edge of shadow is soft.
    const float facing = std::max(0.0F, (studio.light[l].direction.dot(n) + 0.2F) / 1.44F);
    if (facing <= 0) continue;
    const std::vector<Vec3f>& samples = studio.light_samples[l];
    solid.blocked(from, samples, 0, kFar_m, std::span(blocked).first(samples.size()));
    const auto seen = std::count(blocked.begin(), blocked.begin() + std::ssize(samples), std::uint8_t{0});
    arrives += facing * static_cast<float>(seen) / static_cast<float>(samples.size()) *
               studio.light[l].radiance / kPi;
  }
  Vec3f out = surface.albedo.cwiseProduct(arrives);

  // The cornea is a smaller sphere that stands out of the ball: its normals turn faster.
  Vec3f wet = n;
  if (painted) {
    for (int e = 0; e < 2; ++e) {
      const face::Eyeball& ball = face.eyes[static_cast<std::size_t>(e)];
      if (ball.vertex_count == 0 || (neutral - ball.centre_m).norm() > 0.03F) continue;
      const Vec3f axis = eye_turn[static_cast<std::size_t>(e)] * paint.eye_axis(e);
      // By the place instead of the mesh's normals, whose facets a mirror would show.
      const Vec3f out_of_ball =
          eye_turn[static_cast<std::size_t>(e)] * (neutral - ball.centre_m).normalized();
      const float angle = std::acos(std::clamp(out_of_ball.dot(axis), -1.0F, 1.0F));
      const float bulge = 1 - smoothstep(0.85F, 1.15F, angle / paint.iris_angle_rad(e));
      wet = (out_of_ball - 0.40F * bulge * axis).normalized();
    }
  }
  out += mirrored(p, wet, to_camera, 0.12F);
  return out;
}

float Renderer::State::cover_at(const SeenPlace& seen) const {
  return smoothstep(lowest_m + 0.002F, lowest_m + 0.05F, between(seen, face.neutral_m).y());
}

Vec3f Renderer::State::shade(const SeenPlace& seen, const SeenPlace* glass,
                             const ErrorColours* errors) const {
  const auto of_eyeball = [&](std::uint32_t i) {
    return std::ranges::any_of(face.eyes, [&](const face::Eyeball& ball) {
      return i >= ball.first_vertex && i < ball.first_vertex + ball.vertex_count;
    });
  };
  const Vec3f p = between(seen, position);
  const Vec3f& to_camera = seen.to_camera;
  Vec3f n = between(seen, normal).normalized();
  if (n.dot(to_camera) < 0) n = (n - 1.02F * n.dot(to_camera) * to_camera).normalized();
  const Vec3f neutral = between(seen, face.neutral_m);
  const Material made_of = material[seen.triangle];

  Vec3f own_colour = Vec3f::Zero();
  const bool has_colour = !face.colour.empty();
  if (has_colour) own_colour = between(seen, face.colour);
  Surface surface;

  const bool is_cornea = glass != nullptr && of_eyeball(face.triangles[glass->triangle][0]);
  Vec3f out = Vec3f::Zero();
  if (is_eye(made_of)) {
    surface = paint.at(neutral, made_of, has_colour ? &own_colour : nullptr);
    out = shade_eye(p, n, to_camera, surface, neutral, !is_cornea);
  } else {
    const VertexLight arrives = between(seen, light);
    const Vec3f light_here = ambient_of(arrives);

    if (errors != nullptr) {
      const auto& [a, b, c] = face.triangles[seen.triangle];
      const auto& e = errors->error_m;
      const float error_m = seen.weight[0] * e[a] + seen.weight[1] * e[b] + seen.weight[2] * e[c];
      surface.albedo = error_colour(error_m / errors->full_scale_m);
      surface.reflectance = 0.01F;
      surface.roughness = 0.7F;
      surface.scatter = 0.3F;
    } else {
      Place place{.marks = Eigen::Vector2f::Zero(), .footprint_m = view.footprint_m};
      if (!paint.marks().amount.empty()) place.marks = between(seen, paint.marks().amount);
      surface = paint.at(neutral, made_of, has_colour ? &own_colour : nullptr, place);
    }
    // Folds of the skin tilt it, let less light in, and redden what comes back from within.
    Vec3f soft_n = n, in_fold = Vec3f::Ones();
    if (errors == nullptr && !folds.empty() && surface.scatter == 1) {
      const Wrinkles::Slopes slopes = between(seen, folds);
      if (slopes.maxCoeff() > 0) {
        const Wrinkles::Relief relief = wrinkles.at(neutral, n, slopes, view.footprint_m);
        n = (n - relief.slope + relief.slope.dot(n) * n).normalized();
        soft_n = mix(soft_n, n, kFoldsInDiffuse);
        in_fold -= relief.crease * kFoldShade;
      }
    }
    // Pores, where a pixel is small enough to show them.
    const Vec3f rough_n = with_pores(n, neutral, surface.bump, view.footprint_m);

    const Vec3f wrap = surface.scatter * kWrap, unwrap = (1 + wrap.array()).square().inverse();
    Vec3f diffuse = light_here;
    Vec3f shine = Vec3f::Zero();
    const float n_v = std::max(0.05F, rough_n.dot(to_camera));
    for (std::size_t l = 0; l < kLights; ++l) {
      const Look::Light& lamp = studio.light[l];
      const Vec3f visible = visible_of(arrives, l);
      const float facing = (soft_n + 0.35F * (rough_n - n)).dot(lamp.direction);
      const Vec3f wrapped = (Vec3f::Constant(facing) + wrap).cwiseMax(0.0F).cwiseProduct(unwrap);
      diffuse += wrapped.cwiseProduct(visible).cwiseProduct(lamp.radiance) / kPi;

      const float n_l = rough_n.dot(lamp.direction);
      if (n_l <= 0) continue;
      const Vec3f half = (lamp.direction + to_camera).normalized();
      const float n_h = std::clamp(rough_n.dot(half), 0.0F, 1.0F);
      // A wide light widens its highlight; two lobes: skin, and the oil on it.
      const float wide = 0.35F * lamp.radius_rad;
      const float lobes = 0.8F * highlight(n_h, n_v, n_l, std::min(1.0F, surface.roughness + wide)) +
                          0.2F * highlight(n_h, n_v, n_l, std::min(1.0F, 0.6F * surface.roughness + wide));
      shine += fresnel(surface.reflectance, half.dot(to_camera)) * lobes * n_l * visible.z() * lamp.radiance;
    }
    const Vec3f bounced = 2 * rough_n.dot(to_camera) * rough_n - to_camera;
    const float open = light_here.y() / std::max(1e-4F, studio.around(n).y());
    // Of a rough surface little is mirrored even at its edge (Lagarde 2011's roughness-aware Fresnel term).
    const float grazing = 1 - n_v, edge = grazing * grazing * grazing * grazing * grazing;
    const float mirrors =
        surface.reflectance +
        (std::max(1 - surface.roughness, surface.reflectance) - surface.reflectance) * 0.35F * edge;
    shine += 0.8F * mirrors * (1 - 0.6F * surface.roughness) * open * studio.around(bounced);
    out = surface.albedo.cwiseProduct(diffuse).cwiseProduct(in_fold) + in_fold.y() * shine;
  }

  if (errors == nullptr && glass != nullptr) {
    const Vec3f glass_n = between(*glass, normal).normalized();
    // Tears along the lids and over the corners glisten less than the ball itself.
    const float strength = is_cornea ? 1.0F : 0.25F;
    if (glass_n.dot(to_camera) > 0)
      out += strength * mirrored(between(*glass, position), glass_n, to_camera, is_cornea ? 0.12F : 0.9F);
  }
  return out;
}

}  // namespace mien::render
