#include <chrono>
#include <cmath>

#include "mien/imu/pipeline_state.h"

namespace mien::imu {
namespace {

using sensor::Sample;
using sensor::SampleKind;

/// A device time this far behind the newest is a restarted board; less is a sample out of order.
constexpr Duration kRestart = std::chrono::seconds(1);

Vec3 vec3(const Sample& sample, std::size_t at) {
  return Vec3(sample.values[at], sample.values[at + 1], sample.values[at + 2]);
}

}  // namespace

bool Pipeline::State::order(Channel& channel, const Sample& sample, double& dt_s) {
  dt_s = 0;
  if (channel.newest) {
    const Duration since = sample.time - *channel.newest;
    if (since < -kRestart) {
      channel.fusion.restart();
      channel.track.clear();
      channel.restarted = true;
      channel.steady_since = sample.time;
      channel.step = {};
    } else if (since <= Duration::zero()) {
      ++channel.dropped;
      return false;
    } else {
      dt_s = to_seconds(since);
      if (dt_s > settings.fusion.max_gap_s) channel.steady_since = sample.time;
      if (channel.step > Duration::zero() && since > channel.step * 3 / 2)
        channel.lost += static_cast<std::uint64_t>((since + channel.step / 2) / channel.step - 1);
      else
        channel.step = since;
    }
  }
  channel.newest = sample.time;
  return true;
}

void Pipeline::State::add_raw(Channel& channel, const Sample& sample) {
  double dt_s = 0;
  if (!order(channel, sample, dt_s)) return;
  const Vec3 accel = vec3(sample, 3);
  channel.fusion.add(dt_s, vec3(sample, 0), accel);
  if (settings.magnetometer && sample.count >= 9) channel.fusion.fuse_mag(vec3(sample, 6));
  const Quat q = channel.fusion.orientation();
  channel.track.add({sample.time, q, q * accel, channel.fusion.rate_rad_s()});
}

void Pipeline::State::add_fused(Channel& channel, const Sample& sample) {
  double dt_s = 0;
  if (!order(channel, sample, dt_s)) return;
  Quat q(sample.values[0], sample.values[1], sample.values[2], sample.values[3]);
  if (q.norm() < 0.5) return;
  q.normalize();
  Vec3 rate = Vec3::Zero();
  if (dt_s > 0 && !channel.track.empty())
    rate = log_rotation(channel.track.newest().orientation.conjugate() * q) / dt_s;
  channel.track.add({sample.time, q, q * vec3(sample, 4), rate});
  channel.may_be_unchanged = sample.time_estimated;
}

std::optional<FusedSample> Pipeline::State::pose(std::uint16_t sensor, DeviceTime frame) const {
  const Channel& channel = channels[sensor];
  if (channel.track.empty() || !lines->ready() || !lines->has_samples(sensor)) return std::nullopt;
  return channel.track.at(lines->from_line(sensor, frame),
                          channel.may_be_unchanged ? settings.unchanged : settings.silence,
                          settings.prediction);
}

bool Pipeline::State::fresh(std::uint16_t sensor, DeviceTime frame) const {
  const Channel& channel = channels[sensor];
  return channel.may_be_unchanged ||
         lines->from_line(sensor, frame) - channel.track.newest().time <= settings.prediction;
}

void Pipeline::add(const Sample& sample) {
  State& s = *state_;
  if (sample.sensor >= s.channels.size()) return;
  for (const float value : sample.used())
    if (!std::isfinite(value)) return;
  Channel& channel = s.channels[sample.sensor];
  switch (sample.kind) {
    case SampleKind::imu_raw:
      if (sample.count < 6) return;
      s.add_raw(channel, sample);
      return;
    case SampleKind::imu_fused:
      if (sample.count < 7) return;
      s.add_fused(channel, sample);
      return;
    case SampleKind::imu_head_relative:
      if (sample.count < 3) return;
      channel.lab.add(sample.time, vec3(sample, 0));
      return;
    default:  // Another modality's.
      return;
  }
}

}  // namespace mien::imu
