#pragma once

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "lab/imu/impair.h"
#include "mien/imu/packets/packet.h"
#include "mien/sensor/bindings.h"
#include "mien/virtual/imu/device_packet.h"
#include "tests/virtual/three_sensors.h"

namespace mien::lab::test {

/// Twenty seconds and a prologue.
inline const virt::VirtualSession& session() {
  static const virt::VirtualSession played =
      virt::play_devices(
          performer::with_prologue(virt::test::talking(1201), performer::PrologueKind::brief, Random(3)),
          virt::test::three_sites(), virt::test::three_sensors(), virt::test::mild_faults(), Random(11))
          .value();
  return played;
}

inline virt::VirtualSession impaired(const virt::NetworkSettings& settings,
                                     const virt::DeviceTroubles& troubles = {}, std::uint64_t seed = 5) {
  return impair(session(), virt::test::three_sensors(), settings, Random(seed), troubles).value();
}

/// The packets of one device id, in order of arrival, with when.
inline std::vector<std::pair<HostTime, imu::Packet>> packets(const virt::VirtualSession& of,
                                                             std::uint16_t sensor) {
  std::vector<std::pair<HostTime, imu::Packet>> out;
  for (const take::LogEntry& entry : of.entries) {
    const auto packet = imu::parse_packet(entry.bytes);
    if (packet && packet->device == sensor::virtual_device(sensor)) out.emplace_back(entry.arrival, *packet);
  }
  return out;
}

inline double seconds(HostTime time) {
  return to_seconds(time.time_since_epoch());
}

/// What holds of every session: entries by arrival, samples of their entries, ticks on the grid, a truth
/// each.
inline void expect_sound(const virt::VirtualSession& of) {
  for (std::size_t i = 0; i < of.entries.size(); ++i) {
    ASSERT_EQ(of.entries[i].id, static_cast<std::int64_t>(i) + 1);
    if (i > 0) {
      ASSERT_LE(of.entries[i - 1].arrival, of.entries[i].arrival);
    }
  }
  for (std::size_t i = 0; i < of.samples.size(); ++i) {
    ASSERT_GE(of.samples[i].entry, i == 0 ? 1 : of.samples[i - 1].entry);
    ASSERT_LE(of.samples[i].entry, static_cast<std::int64_t>(of.entries.size()));
  }
  ASSERT_EQ(of.truth.size(), of.ticks.size());
  for (std::size_t i = 0; i < of.ticks.size(); ++i) {
    EXPECT_EQ(of.ticks[i].frame, DeviceTime(frame_offset(of.ticks[i].index)));
    EXPECT_EQ(of.truth[i].time, of.ticks[i].frame);
    if (i > 0) {
      ASSERT_EQ(of.ticks[i].index, of.ticks[i - 1].index + 1);
      ASSERT_GE(of.ticks[i].fired, of.ticks[i - 1].fired);
      ASSERT_GE(of.ticks[i].after_entry, of.ticks[i - 1].after_entry);
    }
  }
}

}  // namespace mien::lab::test
