#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/core/time.h"

namespace mien::model {

/// What one face sensor says at one frame: the paper's c = [a, q].
struct SensorFeature {
  Vec3f accel_m_s2 = Vec3f::Zero();  ///< Linear acceleration relative to the head, frame H.
  /// Skin rotation from neutral, E in the head frame: w,x,y,z, unit, w >= 0.
  std::array<float, 4> rotation = {1, 0, 0, 0};
  bool has_accel = false;
  bool has_rotation = false;
  bool operator==(const SensorFeature&) const = default;
};

/// One frame of features of a whole rig: one entry a face sensor, in the rig's order.
struct FeatureFrame {
  DeviceTime time;  ///< Frame time, reference clock.
  std::vector<SensorFeature> sensors;
  Quat head = Quat::Identity();  ///< q_world_head, from the ear sensor; identity when it is missing.
  bool has_head = false;
};

/// How a frame of features becomes the network's condition: for n sensors first 7n numbers (accel xyz,
/// rotation wxyz a sensor), then, unless `faithful`, 2n presence flags (rotation there, acceleration there; 0
/// or 1).
struct FeatureLayout {
  std::vector<std::string> sensors;  ///< Names, as in the rig.
  bool presence_flags = true;        ///< False in the faithful variant.

  [[nodiscard]] std::size_t value_count() const { return 7 * sensors.size(); }
  [[nodiscard]] std::size_t width() const { return (presence_flags ? 9 : 7) * sensors.size(); }
  bool operator==(const FeatureLayout&) const = default;
};

/// Per-value mean and scale, estimated on the training set over present values only.
struct FeatureNormalisation {
  std::vector<float> mean;   ///< Size value_count().
  std::vector<float> scale;  ///< Positive; the standard deviation, floored.
};

/// Values beyond this many scales are held to it: a wild sensor must not take the network outside what it has
/// seen.
inline constexpr float kFeatureClip = 8.0F;

/// Writes the condition of one frame that stands in arrays: `values` are 7n numbers (acceleration xyz,
/// rotation wxyz a sensor), `present` 2n flags (rotation there a sensor, then acceleration there). Missing
/// values become 0 after normalisation (their mean), their flags 0. Shape: out.size() == layout.width().
void encode_values(const FeatureLayout& layout, const FeatureNormalisation& normalisation,
                   std::span<const float> values, std::span<const std::uint8_t> present,
                   std::span<float> out);

}  // namespace mien::model
