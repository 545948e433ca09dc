#include "mien/face/corrective.h"

#include <algorithm>

namespace mien::face {

void add_correctives(std::span<const Corrective> correctives, const BlendshapeWeights& weights,
                     std::span<Vec3f> vertices_m) {
  for (const Corrective& c : correctives) {
    float product = 1;
    for (const Corrective::Driver& d : c.drivers)
      product *= std::clamp(weights[d.shape], d.from, d.until) - d.from;
    if (product == 0) continue;
    for (std::size_t i = 0; i < c.vertex.size(); ++i) vertices_m[c.vertex[i]] += product * c.delta_m[i];
  }
}

}  // namespace mien::face
