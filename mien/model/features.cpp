#include "mien/model/features.h"

#include <algorithm>

namespace mien::model {

namespace {

/// The seven numbers of one sensor: acceleration xyz, rotation wxyz.
void encode_sensor(const FeatureNormalisation& normalisation, std::size_t sensor, const float* values,
                   bool has_rotation, bool has_accel, std::span<float> out) {
  for (std::size_t i = 0; i < 7; ++i) {
    const std::size_t at = 7 * sensor + i;
    const float scaled = (values[i] - normalisation.mean[at]) / normalisation.scale[at];
    out[at] = (i < 3 ? has_accel : has_rotation) ? std::clamp(scaled, -kFeatureClip, kFeatureClip) : 0.0F;
  }
}

}  // namespace

void encode_values(const FeatureLayout& layout, const FeatureNormalisation& normalisation,
                   std::span<const float> values, std::span<const std::uint8_t> present,
                   std::span<float> out) {
  const std::size_t n = layout.sensors.size();
  eigen_assert(values.size() == 7 * n && present.size() == 2 * n && out.size() == layout.width());
  for (std::size_t s = 0; s < n; ++s)
    encode_sensor(normalisation, s, values.data() + 7 * s, present[s] != 0, present[n + s] != 0, out);
  if (layout.presence_flags)
    for (std::size_t i = 0; i < 2 * n; ++i) out[7 * n + i] = present[i] != 0 ? 1.0F : 0.0F;
}

}  // namespace mien::model
