#include "mien/virtual/imu_simulator.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace mien::virt {
namespace {

constexpr double kGravity = 9.80665;
constexpr double kRadPerDeg = std::numbers::pi / 180;
constexpr double kTeslaPerMicrotesla = 1e-6;
/// Central Europe: 20 uT to the north (here +Z, forward), 44 uT downwards.
const Vec3 kMagneticFieldT = Vec3(0, -44, 20) * kTeslaPerMicrotesla;

Vec3 normal_vector(Random& random, double sigma) {
  const double x = random.normal();
  const double y = random.normal();
  const double z = random.normal();
  return sigma * Vec3(x, y, z);
}

/// What a register of 16 bits makes of a value.
double quantised(double value, double range) {
  const double step = range / 32768.0;
  return std::clamp(std::round(value / step), -32768.0, 32767.0) * step;
}

}  // namespace

ImuSimulator::ImuSimulator(const DeviceFaults& faults, std::uint16_t site, Random random)
    : faults_(faults), site_(site), random_(random) {
  // Each fault has a stream of its own: changing one leaves the others as they were.
  Random clock = random.fork("clock");
  clock_.offset_s = clock.uniform(faults.clock_offset_s[0], faults.clock_offset_s[1]);
  clock_.rate = 1 + 1e-6 * clock.normal(0, faults.clock_drift_ppm);
  Random mount = random.fork("mount");
  mount_ = faults.mount_rotation_deg >= 180
               ? mount.rotation()
               : exp_rotation(mount.direction() * mount.uniform(0, faults.mount_rotation_deg) * kRadPerDeg);
  Random adhesive = random.fork("adhesive");
  lag_s_ = 1e-3 * adhesive.uniform(faults.adhesive_lag_ms[0], faults.adhesive_lag_ms[1]);
  Random chip = random.fork("chip");
  gyro_bias_rad_s_ = normal_vector(chip, faults.gyro_bias_dps * kRadPerDeg);
  gyro_scale_ = Vec3::Ones() + normal_vector(chip, faults.gyro_scale);
  accel_bias_m_s2_ = normal_vector(chip, 1e-3 * faults.accel_bias_mg * kGravity);
  accel_scale_ = Vec3::Ones() + normal_vector(chip, faults.accel_scale);
  hard_iron_t_ = normal_vector(chip, faults.mag_hard_iron_ut * kTeslaPerMicrotesla);
}

std::vector<VirtualPacket> ImuSimulator::play(const SkinTrajectory& trajectory) {
  const std::size_t points = trajectory.points;
  const double grid_s = 1 / kTrajectoryRateHz;

  // The sensor on the trajectory's grid: the skin, through the adhesive, slipping.
  std::vector<Quat> orientation(points);
  std::vector<Vec3> position_m(points);
  Random slip_random = random_.fork("slip");
  const double slip_step_rad = faults_.slip_deg_per_sqrt_min * kRadPerDeg * std::sqrt(grid_s / 60.0);
  const double follow = lag_s_ > 0 ? 1 - std::exp(-grid_s / lag_s_) : 1.0;
  Vec3 slip_rad = Vec3::Zero();
  Quat turned = trajectory.rotation[site_][0];
  Vec3 moved = trajectory.position_m[site_][0];
  for (std::size_t i = 0; i < points; ++i) {
    const Quat& skin = trajectory.rotation[site_][i];
    turned = turned * exp_rotation(follow * log_rotation(turned.conjugate() * skin));
    moved += follow * (trajectory.position_m[site_][i] - moved);
    slip_rad += normal_vector(slip_random, slip_step_rad);
    orientation[i] = trajectory.head[i] * turned * exp_rotation(slip_rad) * mount_;
    position_m[i] = trajectory.head_position_m[i] + trajectory.head[i] * moved;
  }

  // The sensor's own grid: samples at k / rate of its clock, orientation and position half a period before
  // and after.
  const auto grid_at = [&](double true_s) {
    const double at = (true_s - trajectory.begin_s) * kTrajectoryRateHz;
    const auto i = std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(std::floor(at)), 1,
                                              static_cast<std::ptrdiff_t>(points) - 3);
    return std::pair{static_cast<std::size_t>(i), at - static_cast<double>(i)};
  };
  const auto orientation_at = [&](double true_s) {
    const auto [i, u] = grid_at(true_s);
    return interpolate_rotation(orientation[i - 1], orientation[i], orientation[i + 1], orientation[i + 2],
                                u);
  };
  const auto position_at = [&](double true_s) {
    const auto [i, u] = grid_at(true_s);
    return interpolate_point(position_m[i - 1], position_m[i], position_m[i + 1], position_m[i + 2], u);
  };

  const double end_s = trajectory.begin_s + static_cast<double>(points - 1) * grid_s;
  const double period_s = 1 / (kImuRateHz * clock_.rate);  // True time between two samples.
  // The first multiple of the device's period that leaves room for the differences; a clock never shows less
  // than zero.
  const auto first = std::max<std::int64_t>(
      0, static_cast<std::int64_t>(
             std::ceil((clock_.offset_s + clock_.rate * (trajectory.begin_s + 3 * grid_s)) * kImuRateHz)));
  const auto last = static_cast<std::int64_t>(
      std::floor((clock_.offset_s + clock_.rate * (end_s - 3 * grid_s)) * kImuRateHz));

  Random noise = random_.fork("noise");
  Random walk = random_.fork("walk");
  Random radio = random_.fork("radio");
  Random loss = random_.fork("loss");
  const double bandwidth = std::sqrt(kImuRateHz / 2);
  const double gyro_sigma = faults_.gyro_noise_dps_sqrt_hz * kRadPerDeg * bandwidth;
  const double accel_sigma = 1e-6 * faults_.accel_noise_ug_sqrt_hz * kGravity * bandwidth;
  const double walk_sigma = faults_.gyro_bias_walk_dps_sqrt_min * kRadPerDeg * std::sqrt(period_s / 60.0);
  const double gyro_range = faults_.gyro_range_dps * kRadPerDeg;
  const double accel_range = faults_.accel_range_g * kGravity;
  Vec3 gyro_bias = gyro_bias_rad_s_;

  std::vector<VirtualPacket> packets;
  packets.reserve(static_cast<std::size_t>(std::max<std::int64_t>(0, last - first)) / kSamplesPerPacket + 1);
  double silent_until_s = -1e9;
  std::uint32_t sequence = 0;
  for (std::int64_t k = first; k + kSamplesPerPacket - 1 <= last; k += kSamplesPerPacket) {
    VirtualPacket packet;
    packet.samples.reserve(kSamplesPerPacket);
    double sent_s = 0;
    for (std::int64_t j = k; j < k + kSamplesPerPacket; ++j) {
      const double true_s = (static_cast<double>(j) / kImuRateHz - clock_.offset_s) / clock_.rate;
      const Quat before = orientation_at(true_s - period_s / 2);
      const Quat after = orientation_at(true_s + period_s / 2);
      const Quat now = orientation_at(true_s);
      const Vec3 rate_rad_s = log_rotation(before.conjugate() * after) / period_s;
      const Vec3 accel_world =
          (position_at(true_s + period_s) - 2 * position_at(true_s) + position_at(true_s - period_s)) /
          (period_s * period_s);
      const Vec3 force = now.conjugate() * (accel_world + Vec3(0, kGravity, 0));

      gyro_bias += normal_vector(walk, walk_sigma);
      const Vec3 gyro = gyro_scale_.cwiseProduct(rate_rad_s) + gyro_bias + normal_vector(noise, gyro_sigma);
      const Vec3 accel =
          accel_scale_.cwiseProduct(force) + accel_bias_m_s2_ + normal_vector(noise, accel_sigma);

      sensor::Sample sample;
      sample.sensor = site_;
      sample.kind = sensor::SampleKind::imu_raw;
      sample.sequence = sequence;
      sample.time = clock_.device(true_s);
      sample.count = 6;
      for (Eigen::Index i = 0; i < 3; ++i) {
        sample.values[static_cast<std::size_t>(i)] = static_cast<float>(quantised(gyro[i], gyro_range));
        sample.values[static_cast<std::size_t>(i) + 3] = static_cast<float>(quantised(accel[i], accel_range));
      }
      if (faults_.magnetometer) {
        const Vec3 field = now.conjugate() * kMagneticFieldT + hard_iron_t_ +
                           normal_vector(noise, faults_.mag_noise_ut * kTeslaPerMicrotesla);
        for (Eigen::Index i = 0; i < 3; ++i)
          sample.values[static_cast<std::size_t>(i) + 6] = static_cast<float>(field[i]);
        sample.count = 9;
      }
      packet.samples.push_back(sample);
      sent_s = true_s;
    }
    ++sequence;
    const double delay_s = 1e-3 * (faults_.radio_delay_min_ms + radio.exponential(faults_.radio_delay_ms));
    packet.arrival = HostTime(from_seconds(sent_s + delay_s));
    const bool lost = loss.chance(faults_.packet_loss);
    // Whole sensors fall silent for 1 to 10 s.
    if (loss.chance(faults_.sensor_loss_per_hour / 3600.0 * kSamplesPerPacket * period_s))
      silent_until_s = sent_s + loss.uniform(1, 10);
    if (!lost && sent_s > silent_until_s) packets.push_back(std::move(packet));
  }
  return packets;
}

}  // namespace mien::virt
