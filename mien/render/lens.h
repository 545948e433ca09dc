#pragma once

#include <Eigen/Core>
#include <span>

#include "mien/core/rotation.h"
#include "mien/render/raster.h"

namespace mien::render {

/// A camera close to a face, through a lens that bends straight lines, as headsets have them. A direction
/// whose tangent off the axis is r appears at r (1 + k1 r^2) (Brown 1966, its first radial term). Frame H,
/// metres; pixels to the right and down from the picture's upper left corner.
struct Lens {
  int width = 240, height = 240;  ///< Pixels.
  Vec3f position_m = Vec3f::Zero();
  /// Unit, at right angles; `forward` along the axis.
  Vec3f forward = -Vec3f::UnitZ(), right = -Vec3f::UnitX(), up = Vec3f::UnitY();
  float pixel = 0.01F;                                         ///< Tangent that one fills on the axis.
  float k1 = 0;                                                ///< Below 0: barrel.
  Eigen::Vector2f centre_px = Eigen::Vector2f::Constant(120);  ///< Where the axis meets the picture.

  /// Not visible (inverse_depth 0) behind the camera and where the lens would fold the picture over.
  [[nodiscard]] ScreenPoint project(const Vec3f& p_m) const;
  /// The same of many, which is cheaper; coordinates beside each other. Shapes: all alike.
  void project(std::span<const float> x_m, std::span<const float> y_m, std::span<const float> z_m,
               std::span<ScreenPoint> out) const;
  /// Towards what is seen at x, y; unit. Beyond the lens's image circle the direction of its rim.
  [[nodiscard]] Vec3f ray(float x, float y) const;
};

/// A lens that looks at `look_at_m`; `field_of_view_rad` is the longer side's, as if k1 were 0.
[[nodiscard]] Lens make_lens(const Vec3f& position_m, const Vec3f& look_at_m, const Vec3f& up,
                             float field_of_view_rad, float k1, int width, int height);

}  // namespace mien::render
