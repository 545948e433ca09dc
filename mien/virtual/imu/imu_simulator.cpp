#include "mien/virtual/imu/imu_simulator.h"

#include <algorithm>
#include <cmath>

#include "mien/core/units.h"
#include "mien/imu/packets/packet.h"

namespace mien::virt {
namespace {

constexpr double kTeslaPerMicrotesla = 1e-6;
/// Central Europe: 20 uT to the north (here +Z, forward), 44 uT downwards.
const Vec3 kMagneticFieldT = Vec3(0, -44, 20) * kTeslaPerMicrotesla;

/// Grid points that are kept when all samples before them are made: a packet and what its differences reach.
constexpr std::size_t kKeptPoints = 32;

/// What a register of 16 bits makes of a value.
double quantised(double value, double range) {
  const double step = range / 32768.0;
  return std::clamp(std::round(value / step), -32768.0, 32767.0) * step;
}

/// The code of the smallest range that the chip has and that reaches `wanted`: range = least * 2^code.
std::uint8_t range_code(double wanted, double least, std::uint8_t most) {
  std::uint8_t code = 0;
  while (code < most && least * std::exp2(code) < wanted * (1 - 1e-9)) ++code;
  return code;
}

}  // namespace

Result<std::vector<std::byte>> encode_device_packet(const VirtualPacket& packet,
                                                    const sensor::DeviceKey& device,
                                                    const DeviceFaults& faults) {
  MIEN_TRY_ASSIGN(imu::Packet out, imu::make_packet(packet.samples));
  out.device = device.device;
  out.channel = device.channel;
  out.gyro_range = range_code(faults.gyro_range_dps, 16, 6);
  out.accel_range = range_code(faults.accel_range_g, 2, 3);
  return imu::encode_packet(out);
}

ImuSimulator::ImuSimulator(const DeviceFaults& faults, std::uint16_t site, Random random)
    : faults_(faults),
      site_(site),
      slip_(random.fork("slip")),
      noise_(random.fork("noise")),
      walk_(random.fork("walk")),
      radio_(random.fork("radio")),
      loss_(random.fork("loss")) {
  // Each fault has a stream of its own: changing one leaves the others as they were.
  clock_ = VirtualClock::drawn(faults.clock_offset_s, faults.clock_drift_ppm, random.fork("clock"));
  Random mount = random.fork("mount");
  mount_ = faults.mount_rotation_deg >= 180
               ? mount.rotation()
               : exp_rotation(mount.direction() * mount.uniform(0, faults.mount_rotation_deg) * kRadPerDeg);
  Random adhesive = random.fork("adhesive");
  lag_s_ = 1e-3 * adhesive.uniform(faults.adhesive_lag_ms[0], faults.adhesive_lag_ms[1]);
  Random chip = random.fork("chip");
  gyro_bias_rad_s_ = chip.normal_vector(faults.gyro_bias_dps * kRadPerDeg);
  gyro_scale_ = Vec3::Ones() + chip.normal_vector(faults.gyro_scale);
  accel_bias_m_s2_ = chip.normal_vector(1e-3 * faults.accel_bias_mg * kStandardGravity_m_s2);
  accel_scale_ = Vec3::Ones() + chip.normal_vector(faults.accel_scale);
  hard_iron_t_ = chip.normal_vector(faults.mag_hard_iron_ut * kTeslaPerMicrotesla);
}

/// The sensor on the trajectory's grid: the skin, through the adhesive, slipping.
void ImuSimulator::follow_skin(const SkinTrajectory& next) {
  constexpr double kGridS = 1 / kTrajectoryRateHz;
  const double slip_step_rad = faults_.slip_deg_per_sqrt_min * kRadPerDeg * std::sqrt(kGridS / 60.0);
  const double follow = lag_s_ > 0 ? 1 - std::exp(-kGridS / lag_s_) : 1.0;
  if (next.first == 0 && next.points > 0) {
    track_.turned = next.rotation[site_][0];
    track_.moved = next.position_m[site_][0];
  }
  for (std::size_t i = 0; i < next.points; ++i) {
    const Quat& skin = next.rotation[site_][i];
    track_.turned = track_.turned * exp_rotation(follow * log_rotation(track_.turned.conjugate() * skin));
    track_.moved += follow * (next.position_m[site_][i] - track_.moved);
    track_.slip_rad += slip_.normal_vector(slip_step_rad);
    track_.orientation.push_back(next.head[i] * track_.turned * exp_rotation(track_.slip_rad) * mount_);
    track_.position_m.push_back(next.head_position_m[i] + next.head[i] * track_.moved);
  }
}

/// The sensor's own grid: samples at k / rate of its clock, orientation and position half a period before and
/// after.
VirtualPacket ImuSimulator::sample_packet(double begin_s) {
  const auto grid_at = [&](double true_s) {
    const double at = (true_s - begin_s) * kTrajectoryRateHz;
    const double i = std::floor(at);
    const auto place = static_cast<std::ptrdiff_t>(i) - static_cast<std::ptrdiff_t>(track_.first);
    return std::pair{static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(
                         place, 1, static_cast<std::ptrdiff_t>(track_.orientation.size()) - 3)),
                     at - i};
  };
  const auto orientation_at = [&](double true_s) {
    const auto [i, u] = grid_at(true_s);
    return interpolate_rotation(track_.orientation[i - 1], track_.orientation[i], track_.orientation[i + 1],
                                track_.orientation[i + 2], u);
  };
  const auto position_at = [&](double true_s) {
    const auto [i, u] = grid_at(true_s);
    return interpolate_point(track_.position_m[i - 1], track_.position_m[i], track_.position_m[i + 1],
                             track_.position_m[i + 2], u);
  };

  const double period_s = 1 / (kImuRateHz * clock_.rate);  // True time between two samples.
  const double bandwidth = std::sqrt(kImuRateHz / 2);
  const double gyro_sigma = faults_.gyro_noise_dps_sqrt_hz * kRadPerDeg * bandwidth;
  const double accel_sigma = 1e-6 * faults_.accel_noise_ug_sqrt_hz * kStandardGravity_m_s2 * bandwidth;
  const double walk_sigma = faults_.gyro_bias_walk_dps_sqrt_min * kRadPerDeg * std::sqrt(period_s / 60.0);
  const double gyro_range = faults_.gyro_range_dps * kRadPerDeg;
  const double accel_range = faults_.accel_range_g * kStandardGravity_m_s2;

  VirtualPacket packet;
  packet.samples.reserve(kSamplesPerPacket);
  double sent_s = 0;
  for (int j = 0; j < kSamplesPerPacket; ++j, ++*next_) {
    const double true_s = (static_cast<double>(*next_) / kImuRateHz - clock_.offset_s) / clock_.rate;
    const Quat before = orientation_at(true_s - period_s / 2);
    const Quat after = orientation_at(true_s + period_s / 2);
    const Quat now = orientation_at(true_s);
    Vec3 rate_rad_s = log_rotation(before.conjugate() * after) / period_s;
    if (true_s >= felt_.begin_s && true_s < felt_.end_s)
      rate_rad_s += now.conjugate() * Vec3(0, felt_.rate_rad_s, 0);
    const Vec3 accel_world =
        (position_at(true_s + period_s) - 2 * position_at(true_s) + position_at(true_s - period_s)) /
        (period_s * period_s);
    const Vec3 force = now.conjugate() * (accel_world + Vec3(0, kStandardGravity_m_s2, 0));

    gyro_bias_rad_s_ += walk_.normal_vector(walk_sigma);
    const Vec3 gyro =
        gyro_scale_.cwiseProduct(rate_rad_s) + gyro_bias_rad_s_ + noise_.normal_vector(gyro_sigma);
    const Vec3 accel =
        accel_scale_.cwiseProduct(force) + accel_bias_m_s2_ + noise_.normal_vector(accel_sigma);

    sensor::Sample sample;
    sample.sensor = site_;
    sample.kind = sensor::SampleKind::imu_raw;
    sample.sequence = sequence_;
    sample.time = clock_.device(true_s);
    sample.count = 6;
    for (Eigen::Index i = 0; i < 3; ++i) {
      sample.values[static_cast<std::size_t>(i)] = static_cast<float>(quantised(gyro[i], gyro_range));
      sample.values[static_cast<std::size_t>(i) + 3] = static_cast<float>(quantised(accel[i], accel_range));
    }
    if (faults_.magnetometer) {
      const Vec3 field = now.conjugate() * kMagneticFieldT + hard_iron_t_ +
                         noise_.normal_vector(faults_.mag_noise_ut * kTeslaPerMicrotesla);
      for (Eigen::Index i = 0; i < 3; ++i)
        sample.values[static_cast<std::size_t>(i) + 6] = static_cast<float>(field[i]);
      sample.count = 9;
    }
    packet.samples.push_back(sample);
    sent_s = true_s;
  }
  ++sequence_;
  const double delay_s = 1e-3 * (faults_.radio_delay_min_ms + radio_.exponential(faults_.radio_delay_ms));
  packet.arrival = HostTime(from_seconds(sent_s + delay_s));
  packet.delay = from_seconds(delay_s);
  const bool lost = loss_.chance(faults_.packet_loss);
  // Whole sensors fall silent for 1 to 10 s.
  if (loss_.chance(faults_.sensor_loss_per_hour / 3600.0 * kSamplesPerPacket * period_s))
    silent_until_s_ = sent_s + loss_.uniform(1, 10);
  packet.lost = lost || sent_s <= silent_until_s_;
  return packet;
}

std::vector<VirtualPacket> ImuSimulator::play(const SkinTrajectory& next) {
  constexpr double kGridS = 1 / kTrajectoryRateHz;
  follow_skin(next);
  const std::size_t traced = track_.first + track_.orientation.size();
  if (traced == 0) return {};
  // The first multiple of the device's period that leaves room for the differences; a clock never shows less
  // than zero.
  if (!next_)
    next_ = std::max<std::int64_t>(
        0, static_cast<std::int64_t>(
               std::ceil((clock_.offset_s + clock_.rate * (next.begin_s + 3 * kGridS)) * kImuRateHz)));
  const double end_s = next.begin_s + static_cast<double>(traced - 1) * kGridS;
  const auto last = static_cast<std::int64_t>(
      std::floor((clock_.offset_s + clock_.rate * (end_s - 3 * kGridS)) * kImuRateHz));

  std::vector<VirtualPacket> packets;
  while (*next_ + kSamplesPerPacket - 1 <= last) packets.push_back(sample_packet(next.begin_s));

  if (const std::size_t size = track_.orientation.size(); size > kKeptPoints) {
    const auto done = static_cast<std::ptrdiff_t>(size - kKeptPoints);
    track_.orientation.erase(track_.orientation.begin(), track_.orientation.begin() + done);
    track_.position_m.erase(track_.position_m.begin(), track_.position_m.begin() + done);
    track_.first += size - kKeptPoints;
  }
  return packets;
}

}  // namespace mien::virt
