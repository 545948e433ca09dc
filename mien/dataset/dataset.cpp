#include "mien/dataset/dataset.h"

#include <algorithm>

namespace mien::dataset {

void append_frame(std::span<const model::SensorFeature> sensors, const face::BlendshapeWeights& weights,
                  Sequence& out) {
  for (const model::SensorFeature& s : sensors) {
    out.values.insert(out.values.end(), s.accel_m_s2.data(), s.accel_m_s2.data() + 3);
    out.values.insert(out.values.end(), s.rotation.begin(), s.rotation.end());
  }
  for (const model::SensorFeature& s : sensors) out.present.push_back(s.has_rotation ? 1 : 0);
  for (const model::SensorFeature& s : sensors) out.present.push_back(s.has_accel ? 1 : 0);
  for (const float w : weights.values) out.weights.push_back(std::clamp(w, 0.0F, 1.0F));
  ++out.frames;
}

}  // namespace mien::dataset
