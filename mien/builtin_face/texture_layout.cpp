#include "mien/builtin_face/builtin_face.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/mesh.h"
#include "mien/builtin_face/surface.h"
#include "mien/core/units.h"

namespace mien::builtin_face {
namespace {

using Eigen::Vector2d;

/// Skin above, ears and eyeballs below; a little room between them.
constexpr double kSkinHeight = 0.79, kMargin = 0.004;

/// How far along a picture a value lies when its surroundings take room by `density`: 0 at `first`, 1 at
/// `last`.
template <class Density>
class Scale {
 public:
  Scale(double first, double last, const Density& density) : first_(first), step_((last - first) / kSteps) {
    sum_[0] = 0;
    for (std::size_t i = 0; i < kSteps; ++i)
      sum_[i + 1] = sum_[i] + density(first + (static_cast<double>(i) + 0.5) * step_);
  }
  [[nodiscard]] double operator()(double value) const {
    const double at = std::clamp((value - first_) / step_, 0.0, static_cast<double>(kSteps));
    const auto i = std::min(static_cast<std::size_t>(at), kSteps - 1);
    return mix(sum_[i], sum_[i + 1], at - static_cast<double>(i)) / sum_[kSteps];
  }

 private:
  static constexpr std::size_t kSteps = 400;
  double first_, step_;
  std::array<double, kSteps + 1> sum_{};
};

/// The face is what people look at; all by eye.
double density_of_azimuth(double azimuth_rad) {
  return mix(2.4, 1.0, smoothstep(50, 90, azimuth_rad / kRadPerDeg));
}
double density_of_row(double row) {
  if (row > kCrownRow) return mix(1.5, 0.5, smoothstep(kCrownRow, kTopRow, row));
  if (row > kChinRow) return 1.5;
  return row > kThroatRow ? mix(1.5, 0.9, (kChinRow - row) / (kChinRow - kThroatRow)) : 0.5;
}

/// The layout of the default head's vertices; that of all others is the same.
std::vector<Eigen::Vector2f> layout() {
  const Sculpt& sculpt = default_sculpt();
  const Scale across(0, M_PI, density_of_azimuth), up(kNeckRow, kTopRow, density_of_row);
  constexpr double kBelow = 0.5 * (1 + kSkinHeight), kHalfBelow = 0.5 * (1 - kSkinHeight) - kMargin;
  std::vector<Eigen::Vector2f> uv;
  for (const SculptVertex& v : sculpt.vertices) {
    const double side = v.p.x() < 0 ? -1 : 1, r = v.chart.x(), c = std::cos(v.chart.y()),
                 s = std::sin(v.chart.y());
    Vector2d at = v.uv.cast<double>();
    switch (v.tissue) {
      case Tissue::skin:
      case Tissue::lip:
      case Tissue::lid_inside:
        at = {0.5 + 0.5 * side * across(v.chart.x()), kSkinHeight * (1 - up(v.chart.y()))};
        break;
      case Tissue::ear:  // Lying: its top to the right.
        at = {0.15 + (side > 0 ? 0 : 0.3) + (0.15 - kMargin) * r * s, kBelow + side * kHalfBelow * r * c};
        break;
      case Tissue::eyeball:
        at = {(side > 0 ? 0.7 : 0.9) + (0.1 - kMargin) * r * c, kBelow - (0.1 - kMargin) * r * s};
        break;
      default:
        break;
    }
    uv.push_back(at.cast<float>());
  }
  return uv;
}

}  // namespace

void lay_out_textures(face::Face& builtin) {
  static const std::vector<Eigen::Vector2f> kLayout = layout();
  std::ranges::copy(kLayout, builtin.uv.begin());
}

}  // namespace mien::builtin_face
