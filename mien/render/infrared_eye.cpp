#include "mien/render/infrared_state.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mien/core/smoothstep.h"
#include "mien/render/solid_noise.h"

namespace mien::render {
namespace {

/// Gullstrand's schematic eye, shares of the ball's radius of 12 mm.
constexpr float kCorneaRadius = 7.8F / 12, kCorneaCentre = 5.6F / 12;
/// The iris lies this far before the ball's centre: 3.4 mm behind the cornea's apex.
constexpr float kIrisDepth = 10.0F / 12;
constexpr float kAqueous = 1.336F;  // Index of refraction.
/// Mirror reflection of cornea and tears straight on.
constexpr float kCorneaMirror = 0.025F;
/// Tears over the white are uneven: glints there are wide.
constexpr float kTearSpread_rad = 0.12F;
constexpr float kPupilAlbedo = 0.004F;
/// A glint's least width, rad.
constexpr float kLeastSpread_rad = 0.02F;

/// Distance along the ray to the first meeting with a sphere; below 0: none.
float meets(const Vec3f& from, const Vec3f& view, const Vec3f& centre, float radius) {
  const Vec3f to = centre - from;
  const float along = to.dot(view), square = radius * radius - (to.squaredNorm() - along * along);
  return square < 0 ? -1.0F : along - std::sqrt(square);
}

/// The iris's albedo at a place of its plane, in its rim's radii.
float iris_albedo(const InfraredEye& look, float x, float y) {
  const float radius = std::sqrt(x * x + y * y), turn = std::atan2(y, x);
  const float fibres =
      0.6F * solid_noise(Vec3f(9 * std::cos(turn), 9 * std::sin(turn), 1.6F * radius + look.person)) +
      0.4F * solid_noise(Vec3f(23 * std::cos(turn), 23 * std::sin(turn), 3 * radius + look.person));
  // A paler ring about the pupil, a darker one at the rim.
  const float ring =
      1 + 0.25F * (1 - smoothstep(0.35F, 0.65F, radius)) - 0.35F * smoothstep(0.82F, 1.0F, radius);
  return std::max(0.01F, look.iris * ring * (1 + look.fibres * fibres));
}

}  // namespace

float lamp_irradiance(const InfraredLamp& lamp, const Vec3f& p_m) {
  const Vec3f way = p_m - lamp.position_m;
  const float square = std::max(way.squaredNorm(), 1e-6F), cosine = way.dot(lamp.aim) / std::sqrt(square);
  if (cosine <= 0) return 0;
  return lamp.intensity * (lamp.narrow == 1 ? cosine : std::pow(cosine, lamp.narrow)) / square;
}

float mirrored_lamps(std::span<const InfraredLamp> lamps, const Vec3f& p_m, const Vec3f& normal,
                     const Vec3f& view, float share, float spread_rad) {
  const float facing = -normal.dot(view);
  if (facing <= 0) return 0;
  const Vec3f mirrored = view + 2 * facing * normal;
  // Schlick 1994, "An inexpensive BRDF model", doi:10.1111/1467-8659.1330233.
  const float flat = 1 - facing, flat2 = flat * flat;
  const float mirror = share + (1 - share) * flat2 * flat2 * flat;
  float sum = 0;
  for (const InfraredLamp& lamp : lamps) {
    const Vec3f way = lamp.position_m - p_m;
    const float distance = way.norm();
    const float cosine = way.dot(mirrored) / distance;
    if (cosine < 0.8F) continue;
    const float size = lamp.radius_m / distance;
    const float spread2 =
        std::max(kLeastSpread_rad * kLeastSpread_rad, spread_rad * spread_rad + size * size);
    // The lamp's light in a lobe about the mirrored direction: 2 (1 - cos) is the angle's square.
    const float exponent = (1 - cosine) / spread2;
    if (exponent > 8) continue;
    sum +=
        mirror * lamp_irradiance(lamp, p_m) * std::exp(-exponent) / (2 * std::numbers::pi_v<float> * spread2);
  }
  return sum;
}

float eye_radiance(const InfraredEye& look, const SeenEye& eye, const Vec3f& from_m, const Vec3f& view,
                   const Vec3f& ball_m, const FallingLight& light, std::span<const InfraredLamp> lamps,
                   float spread_m) {
  const float limbus_m = look.limbus_m * eye.radius_m / 0.012F;
  const Vec3f cornea_m = eye.centre_m + kCorneaCentre * eye.radius_m * eye.axis;
  const float cornea_radius_m = kCorneaRadius * eye.radius_m;
  const float way = meets(from_m, view, cornea_m, cornea_radius_m);
  const Vec3f met_m = from_m + way * view;
  const auto lit = [&](const Vec3f& normal) {
    return std::max(0.0F, normal.dot(light.directed)) + light.ambient;
  };
  const Vec3f ball_normal = (ball_m - eye.centre_m).normalized();
  const float off_axis_m = (ball_m - eye.centre_m).cross(eye.axis).norm();
  // The white darkens towards its rim behind the lids' corners.
  const float sclera =
      look.sclera * (1 - 0.2F * smoothstep(1.4F, 2.0F, off_axis_m / limbus_m)) / std::numbers::pi_v<float>;
  const float rim_m = (met_m - eye.centre_m).cross(eye.axis).norm();
  if (way <= 0 || (met_m - eye.centre_m).dot(eye.axis) <= 0 || rim_m > 1.12F * limbus_m) {
    return sclera * lit(ball_normal) + mirrored_lamps(lamps, ball_m, ball_normal, view, kCorneaMirror,
                                                      std::max(kTearSpread_rad, spread_m / eye.radius_m));
  }

  const Vec3f normal = (met_m - cornea_m) / cornea_radius_m;
  // Bent into the cornea (Snell), then to the iris's plane.
  const float facing = std::max(0.0F, -normal.dot(view));
  const float inside = std::sqrt(1 - (1 - facing * facing) / (kAqueous * kAqueous));
  const Vec3f bent = (view + facing * normal) / kAqueous - inside * normal;
  const float plane = kIrisDepth * eye.radius_m - (met_m - eye.centre_m).dot(eye.axis);
  const float steep = bent.dot(eye.axis);
  const Vec3f iris_m = steep < -0.05F ? Vec3f(met_m + plane / steep * bent) : met_m;
  const Vec3f in_plane = iris_m - eye.centre_m;
  const Vec3f across = eye.up.cross(eye.axis);
  const float x = in_plane.dot(across) / limbus_m, y = in_plane.dot(eye.up) / limbus_m;
  const float radius = std::sqrt(x * x + y * y), soft = std::max(0.03F, spread_m / limbus_m);
  const float pupil = eye.pupil_m * eye.radius_m / 0.012F / limbus_m;
  float albedo = iris_albedo(look, x, y);
  albedo = std::lerp(kPupilAlbedo, albedo, smoothstep(pupil - soft, pupil + soft, radius));
  const float white = smoothstep(1.0F - 0.06F, 1.0F + 0.08F, std::max(radius, rim_m / limbus_m));
  const float diffuse =
      std::lerp(albedo / std::numbers::pi_v<float> * lit(eye.axis), sclera * lit(ball_normal), white);
  return diffuse + mirrored_lamps(lamps, met_m, normal, view, kCorneaMirror, 2 * spread_m / cornea_radius_m);
}

}  // namespace mien::render
