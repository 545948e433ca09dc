#pragma once

#include <vector>

#include "mien/core/random.h"
#include "mien/core/time.h"
#include "mien/sensor/sample.h"
#include "mien/virtual/device_faults.h"
#include "mien/virtual/skin_trajectory.h"

namespace mien::virt {

inline constexpr double kImuRateHz = 240.0;
inline constexpr int kSamplesPerPacket = 4;

/// A device's clock against true time: device = offset + rate * true.
struct VirtualClock {
  double offset_s = 0;
  double rate = 1;  ///< 1 + drift.

  [[nodiscard]] DeviceTime device(double true_s) const {
    return DeviceTime(from_seconds(offset_s + rate * true_s));
  }
  [[nodiscard]] double true_s(DeviceTime device_time) const {
    return (to_seconds(device_time.time_since_epoch()) - offset_s) / rate;
  }
};

/// Samples that travel together, and when the host hears them.
struct VirtualPacket {
  HostTime arrival;
  std::vector<sensor::Sample> samples;  ///< SampleKind::imu_raw, kSamplesPerPacket of them.
};

/// One IMU on the skin: everything that its faults drew.
class ImuSimulator {
 public:
  /// `site` indexes the trajectory and is the sample's sensor number. The same random stream gives the same
  /// device.
  ImuSimulator(const DeviceFaults& faults, std::uint16_t site, Random random);

  [[nodiscard]] const VirtualClock& clock() const { return clock_; }

  /// The packets of the whole trajectory that arrive, in the order in which they were sent.
  [[nodiscard]] std::vector<VirtualPacket> play(const SkinTrajectory& trajectory);

 private:
  DeviceFaults faults_;
  std::uint16_t site_;
  Random random_;
  VirtualClock clock_;
  Quat mount_;  // q_skin_sensor.
  double lag_s_ = 0;
  Vec3 gyro_bias_rad_s_ = Vec3::Zero();
  Vec3 gyro_scale_ = Vec3::Ones();
  Vec3 accel_bias_m_s2_ = Vec3::Zero();
  Vec3 accel_scale_ = Vec3::Ones();
  Vec3 hard_iron_t_ = Vec3::Zero();
};

}  // namespace mien::virt
