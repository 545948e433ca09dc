#pragma once

#include <vector>

#include "mien/core/random.h"
#include "mien/model/features.h"

namespace mien::tracker {

/// How features change when the same sensors are put on anew, by another calibration; one sigma each. Fitted
/// to no recording: chosen so that a live model's answers change about as much as they do between two
/// wearings of virtual people (docs/experiments/phone_truth.md).
struct WearingSpread {
  double frame_deg = 2;      ///< The head's axes, all sensors alike: a rotation vector, each axis.
  double axes_deg = 8;       ///< Where a sensor's skin turns to: each axis, each sensor.
  double gain = 0.25;        ///< How far it turns: of the logarithm.
  double offset_deg = 0.9;   ///< Its neutral rotation: each axis.
  double heading_deg = 0.5;  ///< Its heading, which wanders ...
  double heading_s = 10;     ///< ... and is forgotten in so long (time constant).
};

/// A take's features as if its sensors were worn anew. The same stream gives the same bits.
class WornAnew {
 public:
  WornAnew(std::size_t sensors, const WearingSpread& spread, const Random& random);
  /// The next frame, in place: one a sixtieth of a second. Missing sensors stay missing.
  void apply(model::FeatureFrame& frame);

 private:
  struct Sensor {
    Quat axes;
    double gain = 1;
    Quat offset;
    double heading_rad = 0;
  };
  std::vector<Sensor> sensors_;
  double keep_, step_rad_;  // Of the heading's walk, a frame.
  Random walk_;
};

}  // namespace mien::tracker
