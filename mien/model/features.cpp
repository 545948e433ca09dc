#include "mien/model/features.h"

#include <algorithm>

namespace mien::model {

void encode_features(const FeatureLayout& layout, const FeatureNormalisation& normalisation, const FeatureFrame& frame,
                     std::span<float> out) {
  const std::size_t n = layout.sensors.size();
  eigen_assert(frame.sensors.size() == n && out.size() == layout.width());
  for (std::size_t s = 0; s < n; ++s) {
    const SensorFeature& sensor = frame.sensors[s];
    for (std::size_t i = 0; i < 7; ++i) {
      const std::size_t at = 7 * s + i;
      const bool present = i < 3 ? sensor.has_accel : sensor.has_rotation;
      const float value = i < 3 ? sensor.accel_m_s2[static_cast<Eigen::Index>(i)] : sensor.rotation[i - 3];
      const float scaled = (value - normalisation.mean[at]) / normalisation.scale[at];
      out[at] = present ? std::clamp(scaled, -kFeatureClip, kFeatureClip) : 0.0F;
    }
    if (layout.presence_flags) {
      out[7 * n + s] = sensor.has_rotation ? 1.0F : 0.0F;
      out[8 * n + s] = sensor.has_accel ? 1.0F : 0.0F;
    }
  }
}

}  // namespace mien::model
