#include "lab/spread_on_skin.h"

#include <algorithm>
#include <cmath>

namespace mien::lab {

std::vector<float> spread_on_skin(const face::Face& face, std::span<const Vec3> points_m,
                                  std::span<const double> values, const SkinSpread& spread) {
  std::vector<float> out;
  out.reserve(face.neutral_m.size());
  for (const Vec3f& vertex : face.neutral_m) {
    double sum = 0, weights = 0, nearest_m = spread.reach_m;
    for (std::size_t i = 0; i < points_m.size(); ++i) {
      const double square = (vertex.cast<double>() - points_m[i]).squaredNorm();
      const double near = square + spread.sharp_m * spread.sharp_m;
      const double weight = 1 / (near * near);
      sum += weight * values[i];
      weights += weight;
      nearest_m = std::min(nearest_m, std::sqrt(square));
    }
    const double fade = std::clamp((spread.reach_m - nearest_m) / spread.fade_m, 0.0, 1.0);
    out.push_back(static_cast<float>(fade * sum / weights));
  }
  return out;
}

}  // namespace mien::lab
