#include "mien/session/tap_watch.h"

#include <algorithm>
#include <utility>

namespace mien::session {
namespace {

/// A finger's tap changes the force by tens of m/s^2 from one sample to the next at 240 Hz; a face by few.
constexpr float kTap_m_s2 = 8;
/// What a tap shakes is told by then, whatever the radio does.
constexpr Duration kAllHeard = std::chrono::milliseconds(120);

std::optional<Vec3f> force_of(const sensor::Sample& sample) {
  switch (sample.kind) {
    case sensor::SampleKind::imu_raw:
      return Vec3f(sample.values[3], sample.values[4], sample.values[5]);
    case sensor::SampleKind::imu_fused:
      return Vec3f(sample.values[4], sample.values[5], sample.values[6]);
    case sensor::SampleKind::imu_head_relative:
    case sensor::SampleKind::eyewear_light:
      break;
  }
  return std::nullopt;
}

}  // namespace

void TapWatch::arm(std::string sensor) {
  sensor_ = std::move(sensor);
  devices_.fill({});
  first_.reset();
}

std::optional<sensor::DeviceKey> TapWatch::add(HostTime arrival, const sensor::Reading& reading) {
  if (sensor_.empty()) return std::nullopt;
  if (first_ && arrival - *first_ > kAllHeard) {
    const auto tapped = std::ranges::max_element(devices_, {}, &Device::jump_m_s2);
    return tapped->key;
  }
  const std::optional<Vec3f> force = force_of(reading.sample);
  if (!force) return std::nullopt;
  for (Device& device : devices_) {
    if (device.used && device.key != reading.from) continue;
    if (device.used) {
      const float jump = (*force - device.force_m_s2).norm();
      if (jump > kTap_m_s2 && !first_) first_ = arrival;
      if (first_) device.jump_m_s2 = std::max(device.jump_m_s2, jump);
    }
    device.used = true;
    device.key = reading.from;
    device.force_m_s2 = *force;
    break;
  }
  return std::nullopt;
}

}  // namespace mien::session
