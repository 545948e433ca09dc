#pragma once

#include <string>
#include <vector>

#include "mien/face/motion.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/imu/device_faults.h"
#include "mien/virtual/imu/skin_site.h"
#include "mien/virtual/session.h"
#include "tests/performer/talking.h"

namespace mien::virt::test {

/// Two sensors on the face and one behind the ear, with the default rig's names.
inline constexpr const char* kRig =
    "name = \"three\"\nreference = \"mastoid_L\"\n"
    "[[sensor]]\nname = \"mentalis\"\nkind = \"imu\"\nsite = \"mentalis\"\nside = \"M\"\nrole = \"face\"\n"
    "position_m = [0, -0.0684, 0.1087]\n"
    "[[sensor]]\nname = \"buccinator_L\"\nkind = \"imu\"\nsite = \"buccinator\"\nside = \"L\"\nrole = "
    "\"face\"\nposition_m = [0.0393, -0.0363, 0.0902]\n"
    "[[sensor]]\nname = \"mastoid_L\"\nkind = \"imu\"\nsite = \"mastoid\"\nside = \"L\"\nrole = \"head\"\n"
    "position_m = [0.06, -0.0076, -0.0164]\n";

inline sensor::Rig three_sensors() {
  return sensor::parse_rig(kRig, "three").value();
}

/// A patch of skin that one shape turns: the points (x, y, 0) of the patch move by (0, 0, slope y), which is
/// a turn about +X.
inline SkinSite site_turned_by(std::size_t shape, double slope) {
  SkinSite site;
  site.position_m = Vec3(0, 0, 0.12);
  site.covariance = Vec3(1e-5, 1e-5, 1e-7).asDiagonal();
  for (auto& c : site.shape_covariance) c.setZero();
  for (auto& d : site.shape_shift_m) d.setZero();
  if (shape < face::kShapeCount) site.shape_covariance[shape](1, 2) = slope * 1e-5;
  return site;
}

/// Sites for three_sensors(): jawOpen turns the chin, mouthSmile_L the cheek, nothing the ear.
inline std::vector<SkinSite> three_sites() {
  return {site_turned_by(face::shape("jawOpen"), 0.3), site_turned_by(face::shape("mouthSmile_L"), 0.5),
          site_turned_by(face::kShapeCount, 0)};
}

using performer::test::talking;

/// Small faults of every kind but lost packets.
inline DeviceFaults mild_faults() {
  DeviceFaults faults;
  faults.mount_rotation_deg = 180;
  faults.gyro_noise_dps_sqrt_hz = 0.015;
  faults.gyro_bias_dps = 1;
  faults.accel_noise_ug_sqrt_hz = 200;
  faults.clock_offset_s = {1, 50};
  faults.clock_drift_ppm = 20;
  faults.radio_delay_min_ms = 1;
  faults.radio_delay_ms = 3;
  return faults;
}

}  // namespace mien::virt::test
