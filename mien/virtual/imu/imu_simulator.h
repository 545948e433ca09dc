#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/core/time.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/sample.h"
#include "mien/virtual/imu/device_faults.h"
#include "mien/virtual/imu/skin_trajectory.h"
#include "mien/virtual/virtual_clock.h"

namespace mien::virt {

inline constexpr double kImuRateHz = 240.0;
inline constexpr int kSamplesPerPacket = 4;

/// Samples that travel together, and when they arrive at the host.
struct VirtualPacket {
  HostTime arrival;                     ///< Or when it would have arrived.
  Duration delay{};                     ///< From its last sample to there.
  bool lost = false;                    ///< Sampled, and lost on the way.
  std::vector<sensor::Sample> samples;  ///< SampleKind::imu_raw, kSamplesPerPacket of them.
};

/// The datagram in which a node of our own sends these samples as this device, with the smallest ranges that
/// reach the faults'. Errors: what the packet's encoder finds.
[[nodiscard]] Result<std::vector<std::byte>> encode_device_packet(const VirtualPacket& packet,
                                                                  const sensor::DeviceKey& device,
                                                                  const DeviceFaults& faults);

/// One IMU on the skin: everything that its faults drew, and what it has sampled so far.
class ImuSimulator {
 public:
  /// `site` indexes the trajectory and is the sample's sensor number. The same random stream gives the same
  /// device.
  ImuSimulator(const DeviceFaults& faults, std::uint16_t site, Random random);

  [[nodiscard]] const VirtualClock& clock() const { return clock_; }
  /// How far the adhesive has crept by the newest point of the trajectory: q_skin_now = q_skin_first *
  /// exp_rotation(creep), rad, in the skin's axes.
  [[nodiscard]] const Vec3& creep_rad() const { return track_.slip_rad; }
  /// The sensor is pushed aside on its skin, from the next stretch on: adds this to the creep, rad.
  void push(const Vec3& turn_rad) { track_.slip_rad += turn_rad; }
  /// From `begin_s` to `end_s`, of the trajectory's time and not yet sampled, the gyroscope feels a turn
  /// about the vertical that the sensor does not make, rad in all: the heading that is integrated is off by
  /// so much.
  void feel_turn(double begin_s, double end_s, double angle_rad) {
    felt_ = {begin_s, end_s, angle_rad / (end_s - begin_s)};
  }

  /// The packets that the skin's next stretch completes, also those that are lost, in the order in which they
  /// are sent. Stretches follow one another without a gap from the trajectory's beginning; in whatever
  /// lengths they come, the packets are the same.
  [[nodiscard]] std::vector<VirtualPacket> play(const SkinTrajectory& next);

 private:
  /// The sensor on the trajectory's grid, as much of it as samples still need.
  struct Track {
    std::size_t first = 0;  // Grid points before those that are kept.
    std::vector<Quat> orientation;
    std::vector<Vec3> position_m;
    Quat turned = Quat::Identity();  // The skin as the adhesive passes it on.
    Vec3 moved = Vec3::Zero();
    Vec3 slip_rad = Vec3::Zero();
  };
  void follow_skin(const SkinTrajectory& next);
  [[nodiscard]] VirtualPacket sample_packet(double begin_s);

  DeviceFaults faults_;
  std::uint16_t site_;
  VirtualClock clock_;
  Quat mount_;  // q_skin_sensor.
  double lag_s_ = 0;
  Vec3 gyro_bias_rad_s_ = Vec3::Zero();
  Vec3 gyro_scale_ = Vec3::Ones();
  Vec3 accel_bias_m_s2_ = Vec3::Zero();
  Vec3 accel_scale_ = Vec3::Ones();
  Vec3 hard_iron_t_ = Vec3::Zero();

  // Each has a stream of its own, drawn from as time goes on.
  Random slip_;
  Random noise_;
  Random walk_;
  Random radio_;
  Random loss_;

  Track track_;
  std::optional<std::int64_t> next_;  // The next packet's first sample, in periods of the device's clock.
  std::uint32_t sequence_ = 0;
  double silent_until_s_ = -1e9;

  struct FeltTurn {
    double begin_s = 0, end_s = 0;
    double rate_rad_s = 0;
  } felt_;
};

}  // namespace mien::virt
