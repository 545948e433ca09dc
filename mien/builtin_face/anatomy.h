#pragma once

#include <algorithm>
#include <cmath>

#include "mien/core/rotation.h"
#include "mien/core/smoothstep.h"

/// Measures of the default built-in head. Everything inside the sculptor is in millimetres, as anatomy is
/// written; make_builtin turns it into metres once, at its end. Frame H. Left half (x >= 0); the right is its
/// mirror.
namespace mien::builtin_face {

inline const Vec3 kEyeCentre{32, 36, 84.5};
inline constexpr double kEyeRadius = 12.5;
inline constexpr double kLidRadius = 14.0;  ///< Outside of the lids, about the eyeball's centre.

/// Corners of the eye, in x and y.
inline constexpr double kInnerCanthusX = 17.2, kInnerCanthusY = 33.0;
inline constexpr double kOuterCanthusX = 46.0, kOuterCanthusY = 35.6;

inline constexpr double kMouthCornerX = 25.0, kMouthCornerY = -33.6;

inline const Vec3 kJawHinge{0, -2, 16};  ///< On the axis through both jaw joints.

/// The same place of the other half.
[[nodiscard]] inline Vec3 flip(const Vec3& p) {
  return {-p.x(), p.y(), p.z()};
}

[[nodiscard]] inline double gauss(double x) {
  return std::exp(-x * x);
}
[[nodiscard]] inline double mix(double a, double b, double t) {
  return a + (b - a) * t;
}

/// Where x stands between the corners of the eye: 0 inner, 1 outer.
[[nodiscard]] inline double lid_fraction(double x) {
  return std::clamp((x - kInnerCanthusX) / (kOuterCanthusX - kInnerCanthusX), 0.0, 1.0);
}
/// Toward the inner corner the lids run close together, about the caruncle.
[[nodiscard]] inline double lacrimal_narrowing(double lid_fraction) {
  return mix(0.72, 1.0, smoothstep(0.0, 0.24, lid_fraction));
}
/// Height of the lids' margins at x, eyes open.
[[nodiscard]] inline double upper_lid_y(double x) {
  const double s = lid_fraction(x);
  return mix(kInnerCanthusY, kOuterCanthusY, s) +
         6.7 * lacrimal_narrowing(s) * std::pow(std::sin(M_PI * std::pow(s, 0.86)), 0.66);
}
[[nodiscard]] inline double lower_lid_y(double x) {
  const double s = lid_fraction(x);
  return mix(kInnerCanthusY, kOuterCanthusY, s) -
         4.0 * lacrimal_narrowing(s) * std::pow(std::sin(M_PI * std::pow(s, 1.15)), 0.75);
}

/// How freely skin at a place of the face moves under muscles' pull: 0 at the corners of the eye, which
/// ligaments hold to the bone, to 1 away from the eye.
[[nodiscard]] inline double off_canthi(const Vec3& p) {
  if (p.z() < 60) return 1;
  const double across = (std::abs(p.x()) - 0.5 * (kInnerCanthusX + kOuterCanthusX)) / 17,
               up = (p.y() - 35.5) / 9;
  return smoothstep(0.72, 1.7, across * across + up * up);
}

/// The line where the lips meet, and the borders of their red, at |x|.
[[nodiscard]] inline double lip_line_y(double x) {
  const double s = std::min(std::abs(x) / kMouthCornerX, 1.3);
  return -33.2 - 0.3 * gauss(s / 0.26) + 0.8 * gauss((s - 0.42) / 0.3) - 0.3 * s * s;
}
[[nodiscard]] inline double upper_lip_border_y(double x) {
  const double s = std::min(std::abs(x) / kMouthCornerX, 1.0);
  const double height =
      7.6 * std::pow(1 - s, 0.8) * (1 + 0.55 * s) + 1.2 * gauss((s - 0.2) / 0.15) - 0.8 * gauss(s / 0.11);
  return lip_line_y(x) + std::max(height, 0.0);
}
[[nodiscard]] inline double lower_lip_border_y(double x) {
  const double s = std::min(std::abs(x) / kMouthCornerX, 1.0);
  return lip_line_y(x) - 9.3 * std::pow(1 - s * s, 0.72);
}

/// A dental arch: in the horizontal plane half an ellipse through the teeth's outer faces, mm.
struct DentalArch {
  double half_width, front_z, depth, gum_y;
};
inline constexpr DentalArch kUpperArch{28.5, 104.6, 42, -25.4}, kLowerArch{27, 102.1, 40.5, -43.6};

/// How far `to` (mm) is to go to stand before the teeth of this arch (`up`: the upper one), where it came
/// from before them.
[[nodiscard]] inline Vec3 out_of_teeth(const DentalArch& arch, bool up, const Vec3& home, const Vec3& to) {
  constexpr double kTooth = 11, kClear = 0.4;  // mm
  const auto across = [&](const Vec3& p) {
    return std::hypot(p.x() / arch.half_width, (p.z() - arch.front_z + arch.depth) / arch.depth);
  };
  const double past_gum = up ? arch.gum_y - to.y() : to.y() - arch.gum_y;
  const double near = smoothstep(-4, -1, past_gum) * smoothstep(kTooth + 3, kTooth, past_gum);
  const double r = across(to), least = 1 + kClear / arch.half_width;
  if (near == 0 || to.z() < arch.front_z - arch.depth || across(home) < 0.96 || r >= least)
    return Vec3::Zero();
  return near * (least / r - 1) * Vec3(to.x(), 0, to.z() - arch.front_z + arch.depth);
}

/// Height of the brow's middle at x.
[[nodiscard]] inline double brow_y(double x) {
  return 54.0 + 5.6 * std::sin(M_PI * std::clamp((x - 8) / 66, 0.0, 1.0)) -
         0.0042 * std::max(0.0, x - 34) * (x - 34) * 2.6;
}

}  // namespace mien::builtin_face
