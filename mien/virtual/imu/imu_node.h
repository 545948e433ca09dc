#pragma once

#include <span>

#include "mien/core/error.h"
#include "mien/virtual/imu/imu_simulator.h"
#include "mien/virtual/node.h"

namespace mien::virt {

/// The board of one IMU.
class ImuNode : public Node {
 public:
  /// What the device has sampled next; to be given before it is due. Errors: what the encoders find.
  [[nodiscard]] virtual Result<void> play(std::span<const VirtualPacket> packets) = 0;
};

}  // namespace mien::virt
