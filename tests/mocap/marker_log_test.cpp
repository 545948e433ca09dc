#include "mien/mocap/marker_log.h"

#include <gtest/gtest.h>

namespace mien::mocap::marker_log_test {
namespace {

const std::vector<std::string> kNames = {"tip", "chin"};

HostTime at(int ms) {
  return HostTime(std::chrono::milliseconds(ms));
}

std::vector<std::byte> frame(int ms, std::uint64_t device = 7) {
  MarkerPositionsPacket packet;
  packet.device = device;
  packet.list = marker_list(kNames);
  packet.count = 2;
  packet.time = DeviceTime(std::chrono::milliseconds(1000 + ms));
  packet.position_m[0] = Vec3f(0.001F * static_cast<float>(ms), 0, 0);
  packet.position_m[1] = kLostMarker;
  return encode_marker_positions(packet).value();
}

TEST(MarkerLog, PutsATrackTogether) {
  MarkerLog log;
  log.add(at(3), frame(0));
  log.add(at(8), encode_marker_names(7, kNames)->front());
  log.add(at(14), frame(10));
  log.add(at(15), frame(10));  // Doubled,
  log.add(at(16), frame(5));   // and late.
  log.add(at(25), frame(20));
  log.add(at(26), std::vector<std::byte>(40));  // Somebody else's.
  const auto received = log.received();
  ASSERT_EQ(received.size(), 1u);
  EXPECT_EQ(received[0].device, 7u);
  EXPECT_EQ(received[0].track.markers, kNames);
  EXPECT_EQ(received[0].track.time_s, (std::vector<double>{1, 1.01, 1.02}));
  EXPECT_EQ(received[0].arrival, (std::vector<HostTime>{at(3), at(14), at(25)}));
  EXPECT_FLOAT_EQ(received[0].track.frame(2)[0].x(), 0.02F);
  EXPECT_FALSE(is_seen(received[0].track.frame(2)[1]));
  EXPECT_EQ(log.unnamed(), 0u);
}

TEST(MarkerLog, AServerThatBeganAnewGivesAnotherTrack) {
  MarkerLog log;
  log.add(at(1), encode_marker_names(7, kNames)->front());
  for (int ms = 5000; ms < 5030; ms += 10) log.add(at(ms), frame(ms));
  log.add(at(6000), frame(0));
  log.add(at(6010), frame(10));
  const auto received = log.received();
  ASSERT_EQ(received.size(), 2u);
  ASSERT_EQ(received[0].track.time_s.size(), 3u);
  EXPECT_NEAR(received[0].track.time_s[2], 6.02, 1e-9);
  ASSERT_EQ(received[1].track.time_s.size(), 2u);
  EXPECT_NEAR(received[1].track.time_s[0], 1, 1e-9);
  EXPECT_EQ(received[1].arrival, (std::vector<HostTime>{at(6000), at(6010)}));
  EXPECT_EQ(received[1].track.markers, kNames);
}

TEST(MarkerLog, WhatNobodyNamedIsCounted) {
  MarkerLog log;
  log.add(at(3), frame(0));
  log.add(at(13), frame(10));
  EXPECT_TRUE(log.received().empty());
  EXPECT_EQ(log.unnamed(), 2u);
}

TEST(MarkerLog, ServersAreToldApart) {
  MarkerLog log;
  for (const std::uint64_t device : {7, 8}) log.add(at(1), encode_marker_names(device, kNames)->front());
  log.add(at(3), frame(0));
  log.add(at(4), frame(0, 8));
  log.add(at(14), frame(10, 8));
  const auto received = log.received();
  ASSERT_EQ(received.size(), 2u);
  EXPECT_EQ(received[0].device, 8u);
}

}  // namespace
}  // namespace mien::mocap::marker_log_test
