#include "mien/virtual/imu/device_packet.h"

#include <cmath>

#include "mien/imu/packets/packet.h"

namespace mien::virt {
namespace {

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

}  // namespace mien::virt
