#pragma once

#include <vector>

#include "mien/core/streaming_mode.h"
#include "mien/eyewear/marker_regressor.h"
#include "mien/sensor/rig.h"

namespace mien::eyewear {

/// Takes drift off the features of photo-reflective sensors: as glasses slip and skin sweats, a resting face
/// no longer reads what it read when it was calibrated. The mode of the newest 30 s of a sensor's feature
/// (StreamingMode) is taken for the resting face and subtracted; it is followed by at most 0.02 ranges a
/// second and kMost in all, and a mode beyond kMost is a face that is held, and moves nothing. Only frames in
/// which the sensor is there count; the first ten seconds of them change nothing. Only of sensors whose Mount
/// asks for it: for the others no bit changes. On frames of the 60 Hz grid. No allocation; 2 KB a sensor.
/// What it gains and costs: docs/experiments/shaping.md, "Inputs".
class LightDrift {
 public:
  /// Most drift that is followed either way, in ranges of the sensor (SensorNormalisation::range). Raising:
  /// expressions that are held for half a minute pass for rest. Lowering: a frame that slipped far is not
  /// followed.
  static constexpr float kMost = 0.5F;

  /// Of the rig's photo-reflective sensors, in its order.
  explicit LightDrift(const sensor::Rig& rig);

  /// Learns from a frame's features, `since_s` seconds (above 0) after the last one's, and takes off what has
  /// drifted, in place. Missing sensors keep what was learnt of them.
  void apply(double since_s, LightFrame& features);
  /// There is another neutral: nothing has drifted yet.
  void reset();
  /// What is taken off a sensor's feature, -kMost to kMost.
  [[nodiscard]] float drifted(std::size_t sensor) const { return drifted_[sensor]; }

 private:
  std::vector<std::size_t> followed_;  // Places among the photo-reflective sensors.
  std::vector<StreamingMode> seen_;    // Of each of these: the feature's [-1, 1] as [0, 1].
  std::vector<float> drifted_;         // Of every photo-reflective sensor.
};

}  // namespace mien::eyewear
