#include "mien/session/tap_watch.h"

#include <algorithm>
#include <utility>

#include "mien/sensor/sample_values.h"

namespace mien::session {
namespace {

/// A finger's tap changes the specific force by tens of m/s^2 from one sample to the next at 240 Hz; a face
/// by few.
constexpr float kTap_m_s2 = 8;
/// All devices that a tap shakes have sent it by then, whatever the radio does.
constexpr Duration kAllArrived = std::chrono::milliseconds(120);

}  // namespace

void TapWatch::arm(std::string sensor) {
  sensor_ = std::move(sensor);
  devices_.fill({});
  first_.reset();
}

std::optional<sensor::DeviceKey> TapWatch::add(HostTime arrival, const sensor::Reading& reading) {
  if (sensor_.empty()) return std::nullopt;
  if (first_ && arrival - *first_ > kAllArrived) {
    const auto tapped = std::ranges::max_element(devices_, {}, &Device::jump_m_s2);
    return tapped->key;
  }
  const std::optional<Vec3f> force = sensor::specific_force(reading.sample);
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
