#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/rotation.h"
#include "mien/model/correction.h"
#include "mien/sensor/calibration.h"

namespace mien::imu {

/// Calibration of one face sensor. Frames: S_i the sensor's own, S_h the ear sensor's
/// (docs/reference/frames.md).
struct SensorCalibration {
  bool valid = false;  ///< False: the sensor was missing in the prologue, and stays so.
  /// N_i: from S_i to S_h on the neutral face; the adhesive's creep included, where it is tracked.
  Quat neutral = Quat::Identity();
  double heading_rad = 0;  ///< Z_i: turn about the vertical from this fusion's world to the ear's, (-pi, pi].
  double heading_sigma_rad = 0;  ///< Its standard deviation, 0 to pi.
  /// Head-relative acceleration measured at rest, frame H: the accelerometers' biases.
  Vec3 neutral_accel_m_s2 = Vec3::Zero();
  bool operator==(const SensorCalibration&) const = default;
};

/// Calibration of a rig's IMUs. The identity before the prologue.
struct Calibration {
  bool complete = false;                   ///< Neutral and nod were observed; a shake only adds scores.
  Quat q_head_ear = Quat::Identity();      ///< C: from the ear sensor's axes to the head's.
  double neutral_heading_rad = 0;          ///< Heading of the head in the ear fusion's world at neutral.
  std::vector<SensorCalibration> sensors;  ///< One a face sensor, in the rig's order.
  std::vector<sensor::Score> scores;       ///< Neutral, nod, shake, and one heading a sensor.
  /// Wearer's slopes as personalisation learnt them (model::Skin::wearer, rad per weight); empty: the model's
  /// own.
  std::vector<float> wearer;
  /// What corrects the wearer's answers, as somebody else taught it, in its numbers' written precision
  /// (model::rounded_as_written); none: nothing but what the model came with.
  std::optional<model::Correction> correction;
  bool operator==(const Calibration&) const = default;
};

/// One JSON object; parse_calibration restores an equal value.
[[nodiscard]] std::string write_calibration(const Calibration& calibration);
/// Errors: malformed, out_of_range (not finite, no unit quaternion, more than 256 sensors, slopes of 100 rad
/// or more). `where` names the source in messages.
[[nodiscard]] Result<Calibration> parse_calibration(std::string_view json, const std::string& where);

}  // namespace mien::imu
