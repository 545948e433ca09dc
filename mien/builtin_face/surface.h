#pragma once

#include <algorithm>

#include "mien/core/rotation.h"

namespace mien::builtin_face {

/// Signed distances (mm) to solids; negative inside. The ellipsoid's is about right near its surface.
[[nodiscard]] double ellipsoid(const Vec3& p, const Vec3& centre, const Vec3& radii);
/// A capsule whose radius goes evenly from ra to rb.
[[nodiscard]] double capsule(const Vec3& p, const Vec3& a, double ra, const Vec3& b, double rb);
/// Union with a fillet of about k.
[[nodiscard]] double join(double a, double b, double k);

/// How a ray is followed from outside to where it meets a solid (sphere tracing).
struct RaySteps {
  double from;       ///< Where it begins along its direction, mm: outside.
  int most;          ///< Steps. More: farther along a grazing ray.
  double share;      ///< Of the distance that a step goes, below 1 where it is only about right.
  double near;       ///< On the surface is who is nearer than this, mm.
  double least = 0;  ///< Shortest step, mm.
};
template <class Distance>
[[nodiscard]] Vec3 surface_along(const Vec3& origin, const Vec3& direction, const RaySteps& steps,
                                 const Distance& distance) {
  double r = steps.from;
  for (int i = 0; i < steps.most; ++i) {
    const double d = distance(origin + r * direction);
    if (d < steps.near) break;
    r -= std::max(steps.share * d, steps.least);
  }
  return origin + r * direction;
}

/// The signed distance (mm, about) to the smooth union of skull, flesh and neck; negative inside.
[[nodiscard]] double head_distance(const Vec3& p);

/// Where a ray of the sculptor's family leaves the head. The rays start on the head's axis: level ones over
/// the face, fanned over the crown and under the chin, level again on the neck. `azimuth_rad` 0 is forward,
/// positive to the left; `row` is the height (mm) over the face, an arc above kCrownRow and below kChinRow,
/// and ends at kNeckRow.
[[nodiscard]] Vec3 head_point(double azimuth_rad, double row);

/// Rays of the face start at x = 0 and this z.
inline constexpr double kAxisZ = 10;
inline constexpr double kCrownRow = 60, kTopRow = kCrownRow + 85 * 1.5707963267948966;
inline constexpr double kChinRow = -60, kThroatRow = -108, kNeckRow = -220;

/// The same for a wanted x and y of the face (kChinRow <= y <= kCrownRow).
[[nodiscard]] Vec3 head_point_at(double x, double y);

}  // namespace mien::builtin_face
