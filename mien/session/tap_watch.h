#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "mien/core/rotation.h"
#include "mien/sensor/protocol.h"

namespace mien::session {

/// Finds the device that a finger taps: of all that move, the one whose force jumps most within a moment. The
/// others feel the tap through the skin, but less. A pure function of the calls. No allocation in add.
class TapWatch {
 public:
  /// Waits for a tap, for this sensor of the rig; an empty name waits no more.
  void arm(std::string sensor);
  [[nodiscard]] const std::string& armed() const { return sensor_; }

  /// A sample that carries forces; others are passed over. Returns the device that was tapped once that is
  /// clear, and waits no more.
  [[nodiscard]] std::optional<sensor::DeviceKey> add(HostTime arrival, const sensor::Reading& reading);

 private:
  static constexpr std::size_t kDevices = 64;
  struct Device {
    sensor::DeviceKey key;
    Vec3f force_m_s2 = Vec3f::Zero();
    float jump_m_s2 = 0;  // The largest since the first that was a tap.
    bool used = false;
  };
  std::string sensor_;
  std::array<Device, kDevices> devices_;
  std::optional<HostTime> first_;
};

}  // namespace mien::session
