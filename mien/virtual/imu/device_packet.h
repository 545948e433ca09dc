#pragma once

#include <vector>

#include "mien/core/error.h"
#include "mien/sensor/protocol.h"
#include "mien/virtual/imu/device_faults.h"
#include "mien/virtual/imu/imu_simulator.h"

namespace mien::virt {

/// The datagram in which a node of our own sends these samples as this device, with the smallest ranges that
/// reach the faults'. Errors: what the packet's encoder finds.
[[nodiscard]] Result<std::vector<std::byte>> encode_device_packet(const VirtualPacket& packet,
                                                                  const sensor::DeviceKey& device,
                                                                  const DeviceFaults& faults);

}  // namespace mien::virt
