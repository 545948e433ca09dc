// The packets of virtual nodes, and the rig that knows them.
#include "mien/virtual/imu/imu_simulator.h"

#include <gtest/gtest.h>

#include "mien/imu/packets/packet.h"
#include "mien/sensor/bindings.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/rig.h"
#include "tests/project_path.h"

namespace mien::virt::device_packet_test {
namespace {

TEST(DevicePacket, TheDefaultRigBindsTheVirtualNodes) {
  const sensor::Rig rig = sensor::read_rig(project_path("rigs/default.toml")).value();
  for (std::size_t s = 0; s < rig.sensors.size(); ++s) {
    EXPECT_EQ(sensor::parse_device(rig.sensors[s].device).value(),
              (sensor::DeviceKey{sensor::virtual_device(s), 0}));
    EXPECT_EQ(rig.sensors[s].device, sensor::format_device({sensor::virtual_device(s), 0}));
  }
}

TEST(DevicePacket, HasTheSmallestRangesThatReachTheFaults) {
  VirtualPacket packet;
  sensor::Sample sample;
  sample.sensor = 5;
  sample.sequence = 77;
  sample.time = DeviceTime(std::chrono::seconds(3));
  sample.count = 6;
  packet.samples = {sample};
  for (const auto& [dps, gyro, g, accel] :
       {std::tuple(1024.0, 6, 8.0, 2), std::tuple(16.0, 0, 2.0, 0), std::tuple(17.0, 1, 2.5, 1)}) {
    DeviceFaults faults;
    faults.gyro_range_dps = dps;
    faults.accel_range_g = g;
    const imu::Packet parsed =
        imu::parse_packet(encode_device_packet(packet, {sensor::virtual_device(5), 2}, faults).value())
            .value();
    EXPECT_EQ(parsed.gyro_range, gyro);
    EXPECT_EQ(parsed.accel_range, accel);
    EXPECT_EQ(parsed.device, 0x024D'4945'4E05U);
    EXPECT_EQ(parsed.channel, 2);
    EXPECT_EQ(parsed.sequence, 77U);
  }
}

TEST(DevicePacket, WithoutSamplesThereIsNone) {
  EXPECT_FALSE(encode_device_packet({}, {}, {}));
}

}  // namespace
}  // namespace mien::virt::device_packet_test
