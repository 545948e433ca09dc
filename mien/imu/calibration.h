#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/rotation.h"
#include "mien/sensor/calibration.h"

namespace mien::imu {

/// What the prologue tells of one face sensor. Frames: S_i the sensor's own, S_h the ear sensor's.
struct SensorCalibration {
  bool valid = false;  ///< False: the sensor was silent in the prologue; it stays missing.
  Quat neutral =
      Quat::Identity();    ///< N_i: from S_i to S_h on the neutral face; its creep included, where followed.
  double heading_rad = 0;  ///< Z_i: turn about the vertical from this fusion's world to the ear's, (-pi, pi].
  double heading_sigma_rad = 0;  ///< Its standard deviation.
  Vec3 neutral_accel_m_s2 =
      Vec3::Zero();  ///< Head-relative acceleration read at rest, frame H: the accelerometers' biases.
  bool operator==(const SensorCalibration&) const = default;
};

/// A calibration of a rig's IMUs. Before the prologue, and in the lab profile, the identity.
struct Calibration {
  bool complete = false;                   ///< True when neutral and nod are in; the shake then only judges.
  Quat q_head_ear = Quat::Identity();      ///< C: from the ear sensor's axes to the head's.
  double neutral_heading_rad = 0;          ///< Heading of the head in the ear fusion's world at neutral.
  std::vector<SensorCalibration> sensors;  ///< One a face sensor, in the rig's order.
  std::vector<sensor::Score> scores;       ///< Neutral, nod, shake, and one heading a sensor.
  /// How the wearer's skin turns, as a calibration that learnt it found (model::Skin::wearer); empty: as the
  /// model has it.
  std::vector<float> wearer;
  bool operator==(const Calibration&) const = default;
};

/// JSON, one object; parse_calibration takes it back to an equal value.
[[nodiscard]] std::string write_calibration(const Calibration& calibration);
/// Errors: malformed, out_of_range (not finite, no unit quaternion, more than 256 sensors,
/// slopes of 100 radians).
[[nodiscard]] Result<Calibration> parse_calibration(std::string_view json, const std::string& where);

}  // namespace mien::imu
