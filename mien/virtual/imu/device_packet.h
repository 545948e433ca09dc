#pragma once

#include <cstdint>
#include <vector>

#include "mien/core/error.h"
#include "mien/virtual/imu/device_faults.h"
#include "mien/virtual/imu/imu_simulator.h"

namespace mien::virt {

/// The device of a virtual node: 02:4D:49:45:4E:nn ("MIEN"), nn the sensor's place in the rig, 0 to 255.
[[nodiscard]] constexpr std::uint64_t virtual_device(std::size_t sensor) {
  return 0x024D'4945'4E00ULL + sensor;
}

/// The datagram in which a node of our own sends these samples, with the smallest ranges that reach the
/// faults'. Errors: what the packet's encoder finds.
[[nodiscard]] Result<std::vector<std::byte>> encode_device_packet(const VirtualPacket& packet,
                                                                  const DeviceFaults& faults);

}  // namespace mien::virt
