#pragma once

#include <span>

#include "mien/core/rotation.h"
#include "mien/render/infrared_scene.h"

namespace mien::render {

/// An eyeball where it is now, and what falls onto it.
struct SeenEye {
  Vec3f centre_m = Vec3f::Zero();
  Vec3f axis = Vec3f::UnitZ();  ///< Unit, through the pupil.
  Vec3f up = Vec3f::UnitY();    ///< Unit, at right angles to it; turns the iris's pattern.
  float radius_m = 0.012F;      ///< Of the ball.
  float pupil_m = 0.002F;       ///< Radius.
};

/// What the surface gets: the sum of the lamps' irradiances, each along its direction, W/m^2, and what comes
/// from everywhere.
struct FallingLight {
  Vec3f directed = Vec3f::Zero();  ///< Towards the lamps.
  float ambient = 0;
};

/// The radiance that a camera at `from_m` gets along `view` (unit) of an eye whose ball it meets at `ball_m`.
/// The iris is seen through the cornea, which bends the view and mirrors every lamp. `spread_m`: half the
/// width of what a sample stands for there; a glint is not smaller than that.
[[nodiscard]] float eye_radiance(const InfraredEye& look, const SeenEye& eye, const Vec3f& from_m,
                                 const Vec3f& view, const Vec3f& ball_m, const FallingLight& light,
                                 std::span<const InfraredLamp> lamps, float spread_m);

/// A mirror image of the lamps at p_m, seen along `view` of a surface with this normal that mirrors `share`
/// of the light straight on: radiance. `spread_rad`: half the angle over which the mirrored
/// direction is spread.
[[nodiscard]] float mirrored_lamps(std::span<const InfraredLamp> lamps, const Vec3f& p_m, const Vec3f& normal,
                                   const Vec3f& view, float share, float spread_rad);

/// Irradiance of a lamp at a place that faces it, W/m^2.
[[nodiscard]] float lamp_irradiance(const InfraredLamp& lamp, const Vec3f& p_m);

}  // namespace mien::render
