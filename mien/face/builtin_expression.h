#pragma once

#include <span>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/face/builtin_mesh.h"

namespace mien::face::builtin {

/// Displacement of every vertex of the sculpted head at weight 1 (mm), in the order of kShapeNames and then
/// tongueOut. Right shapes are the mirror images of left ones.
[[nodiscard]] std::vector<std::vector<Vec3>> shape_displacements(const Sculpt& whole);

/// A patch of skin about a sensor's site: points spread evenly over the surface within 5 mm, each a place in
/// a triangle.
struct SkinPatch {
  struct Point {
    std::array<std::uint32_t, 3> corner;
    Vec3 weight;  ///< Barycentric.
    double area_mm2;
  };
  std::vector<Point> points;
};
[[nodiscard]] SkinPatch skin_patch(const Sculpt& whole, const Vec3& site_mm, double radius_mm = 5);
/// The least-squares rigid rotation of the patch, as a rotation vector in degrees.
[[nodiscard]] Vec3 patch_rotation_deg(const Sculpt& whole, const SkinPatch& patch,
                                      std::span<const Vec3> displacement);

/// Adds to each shape a smooth turn of the skin about the sites, so that it turns there as real skin does
/// (docs/builtin_face.md), and brings its peak to the measured one. `displacements` as from
/// shape_displacements.
void tune_kinematics(const Sculpt& whole, std::vector<std::vector<Vec3>>& displacements);

}  // namespace mien::face::builtin
