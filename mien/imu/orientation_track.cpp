#include "mien/imu/orientation_track.h"

#include <algorithm>

namespace mien::imu {
namespace {

constexpr Duration kHalfFrame{1'000'000'000 / 120};

}  // namespace

void OrientationTrack::drop_after(DeviceTime time) {
  while (!samples_.empty() && newest().time > time) samples_.pop();
}

const FusedSample& OrientationTrack::reached(DeviceTime time) const {
  std::size_t i = 0;
  while (i + 1 < samples_.size() && samples_[i + 1].time >= time) ++i;
  return samples_[i];
}

Vec3 OrientationTrack::force_around(DeviceTime time) const {
  Vec3 sum = Vec3::Zero();
  int n = 0;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const FusedSample& entry = samples_[i];
    if (entry.time < time - kHalfFrame) break;
    if (entry.time > time + kHalfFrame) continue;
    sum += entry.force_world_m_s2;
    ++n;
  }
  return n > 0 ? Vec3(sum / n) : newest().force_world_m_s2;
}

std::optional<FusedSample> OrientationTrack::at(DeviceTime time, Duration silence,
                                                Duration prediction) const {
  if (samples_.empty()) return std::nullopt;
  FusedSample out = newest();
  if (time >= out.time) {
    const Duration ahead = time - out.time;
    if (ahead > silence) return std::nullopt;
    out.orientation =
        out.orientation * exp_rotation(out.rate_rad_s * to_seconds(std::min(ahead, prediction)));
  } else {
    std::size_t i = 1;
    while (i < samples_.size() && samples_[i].time > time) ++i;
    if (i == samples_.size()) {
      // Older than the buffer: the oldest sample is held backwards for `silence`.
      out = samples_[samples_.size() - 1];
      if (out.time - time > silence) return std::nullopt;
    } else {
      const FusedSample& before = samples_[i];
      const FusedSample& after = samples_[i - 1];
      if (after.time - before.time > silence) return std::nullopt;
      const double u = to_seconds(time - before.time) / to_seconds(after.time - before.time);
      out.orientation = before.orientation.slerp(u, after.orientation);
      out.rate_rad_s = (1 - u) * before.rate_rad_s + u * after.rate_rad_s;
    }
  }
  out.force_world_m_s2 = force_around(time);
  out.time = time;
  return out;
}

}  // namespace mien::imu
