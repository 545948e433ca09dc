#include "mien/live/network_interfaces.h"

#include <gmock/gmock.h>

#include <algorithm>

namespace mien::live::network_interfaces_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const NetworkInterface kRadio{.name = "wlan0", .address = "192.168.1.7"};
const NetworkInterface kRadio6{.name = "wlan0", .address = "2001:db8::7"};
const NetworkInterface kLoopback{.name = "lo", .address = "127.0.0.1", .loopback = true};
const std::vector<NetworkInterface> kAll = {kRadio, kRadio6, kLoopback};

TEST(NetworkInterfaces, ThisMachinesHaveLoopbackLast) {
  const std::vector<NetworkInterface> all = network_interfaces();
  if (all.empty()) GTEST_SKIP() << "this machine has no network at all";
  EXPECT_TRUE(std::ranges::is_sorted(all, {}, &NetworkInterface::loopback));
  EXPECT_TRUE(all.back().loopback) << all.back().name;
  for (const NetworkInterface& one : all) {
    EXPECT_NE(one.name, "");
    EXPECT_NE(one.address, "");
  }
}

TEST(NetworkInterfaces, APortIsReachedByThoseOfItsFamilyOrByItsOwn) {
  EXPECT_THAT(reached_by("udp://0.0.0.0:5005", kAll), ElementsAre(kRadio, kLoopback));
  EXPECT_THAT(reached_by("udp://[::]:5005", kAll), ElementsAre(kRadio, kRadio6, kLoopback));
  EXPECT_THAT(reached_by("udp://192.168.1.7:5005", kAll), ElementsAre(kRadio));
  EXPECT_THAT(reached_by("udp://[2001:db8::7]:5005", kAll), ElementsAre(kRadio6));
  EXPECT_THAT(reached_by("serial:/dev/ttyUSB0?baud=250000", kAll), IsEmpty());
}

TEST(NetworkInterfaces, WhoCanReachAPortFollowsFromItsAddress) {
  EXPECT_TRUE(is_on_every_interface("udp://0.0.0.0:5005"));
  EXPECT_TRUE(is_on_every_interface("udp://[::]:5005"));
  EXPECT_FALSE(is_on_every_interface("udp://192.168.1.7:5005"));
  EXPECT_FALSE(is_on_every_interface("serial:/dev/ttyUSB0?baud=250000"));
  EXPECT_TRUE(is_on_this_machine("udp://127.0.0.1:5005"));
  EXPECT_TRUE(is_on_this_machine("udp://[::1]:5005"));
  EXPECT_TRUE(is_on_this_machine("serial:/dev/ttyUSB0?baud=250000"));
  EXPECT_FALSE(is_on_this_machine("udp://192.168.1.7:5005"));
  EXPECT_FALSE(is_on_this_machine("udp://0.0.0.0:5005"));
}

}  // namespace
}  // namespace mien::live::network_interfaces_test
