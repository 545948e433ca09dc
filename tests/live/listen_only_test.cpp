// Ports on every interface, narrowed to one entrance and widened again, on this machine's loopback.
#include <utility>  // Before Asio 1.74, which forgets it.

#include <gmock/gmock.h>
#include <net/if.h>

#include <algorithm>
#include <string>
#include <vector>

#include "mien/live/intake.h"
#include "mien/live/network_interfaces.h"
#include "mien/live/udp_arrival.h"
#include "tests/live/page_client.h"

namespace mien::live::listen_only_test {
namespace {

using boost::asio::ip::udp;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class ListenOnly : public ::testing::Test {
 protected:
  std::uint16_t listen(const std::string& address) {
    const auto listening = intake.listen(address);
    EXPECT_TRUE(listening) << listening.error().message();
    // Behind the last colon: an IPv6 address has others.
    return listening ? static_cast<std::uint16_t>(std::stoi(listening->substr(listening->rfind(':') + 1)))
                     : 0;
  }
  void send(const char* to, std::uint16_t port, const std::string& text) {
    const auto address = boost::asio::ip::make_address(to);
    udp::socket from(network, address.is_v6() ? udp::v6() : udp::v4());
    const std::uint64_t before = intake.counts().received;
    from.send_to(boost::asio::buffer(text), {address, port});
    EXPECT_TRUE(test::run_until(network, [&] { return intake.counts().received > before; }));
  }
  std::vector<std::string> take() {
    std::vector<std::string> texts;
    while (const auto arrived = intake.front()) {
      texts.emplace_back(reinterpret_cast<const char*>(arrived->bytes.data()), arrived->bytes.size());
      intake.release();
    }
    return texts;
  }

  boost::asio::io_context network;
  Intake intake{network, [] { return HostTime(); }};
};

TEST_F(ListenOnly, AnAddressLeavesTheOthersOutUntilItIsWidened) {
  const std::uint16_t port = listen("udp://0.0.0.0:0");
  send("127.0.0.1", port, "a");
  send("127.0.0.2", port, "b");
  EXPECT_THAT(take(), ElementsAre("a", "b"));

  ASSERT_TRUE(intake.listen_only("127.0.0.2"));
  EXPECT_EQ(intake.entrance(), "127.0.0.2");
  send("127.0.0.1", port, "c");
  send("127.0.0.2", port, "d");
  EXPECT_THAT(take(), ElementsAre("d"));
  EXPECT_EQ(intake.counts().elsewhere, 1U);

  ASSERT_TRUE(intake.listen_only("127.0.0.1"));
  send("127.0.0.1", port, "e");
  send("127.0.0.2", port, "f");
  EXPECT_THAT(take(), ElementsAre("e"));

  ASSERT_TRUE(intake.listen_only(""));
  EXPECT_EQ(intake.entrance(), "");
  send("127.0.0.1", port, "g");
  send("127.0.0.2", port, "h");
  EXPECT_THAT(take(), ElementsAre("g", "h"));
  EXPECT_EQ(intake.counts().elsewhere, 2U);
}

TEST_F(ListenOnly, AnInterfaceHasAllItsAddresses) {
  const std::uint16_t port = listen("udp://0.0.0.0:0");
  ASSERT_TRUE(intake.listen_only("lo"));
  intake.look_up_entrance();
  send("127.0.0.1", port, "a");
  send("127.0.0.2", port, "b");
  EXPECT_THAT(take(), ElementsAre("a", "b"));
  EXPECT_EQ(intake.counts().elsewhere, 0U);
}

TEST_F(ListenOnly, APortOfBothFamiliesTellsThemApart) {
  udp::socket probe(network, udp::v6());
  boost::system::error_code none;
  probe.bind({boost::asio::ip::address_v6::loopback(), 0}, none);
  if (none) GTEST_SKIP() << "this machine has no IPv6";
  const std::uint16_t port = listen("udp://[::]:0");
  ASSERT_TRUE(intake.listen_only("::1"));
  send("127.0.0.1", port, "a");
  send("::1", port, "b");
  EXPECT_THAT(take(), ElementsAre("b"));
  ASSERT_TRUE(intake.listen_only("127.0.0.2"));
  send("127.0.0.1", port, "c");
  send("::1", port, "d");
  send("127.0.0.2", port, "e");
  EXPECT_THAT(take(), ElementsAre("e"));
  EXPECT_EQ(intake.counts().elsewhere, 3U);
}

TEST_F(ListenOnly, PortsOfOneAddressStayAsTheyAre) {
  listen("udp://0.0.0.0:0");
  const std::uint16_t own = listen("udp://127.0.0.1:0");
  ASSERT_TRUE(intake.listen_only("127.0.0.2"));
  send("127.0.0.1", own, "a");
  EXPECT_THAT(take(), ElementsAre("a"));
}

TEST_F(ListenOnly, WhatIsNotHereIsRefusedAndChangesNothing) {
  EXPECT_THAT(intake.listen_only("lo").error().message(), HasSubstr("no port listens on every interface"));
  listen("udp://0.0.0.0:0");
  ASSERT_TRUE(intake.listen_only("127.0.0.2"));
  for (const char* wrong : {"no_such_interface", "192.0.2.1", "0.0.0.0", "224.0.0.1", "127.0.0.1:5005"}) {
    const auto refused = intake.listen_only(wrong);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().code, ErrorCode::bad_usage);
    EXPECT_THAT(refused.error().message(), HasSubstr(wrong));
  }
  EXPECT_FALSE(intake.listen_only("::1")) << "no port is of that family";
  EXPECT_EQ(intake.entrance(), "127.0.0.2");
}

TEST(UdpEntrance, AnInterfaceRefusesWhatCameInByAnother) {
  const auto loopback = UdpEntrance::find("lo");
  ASSERT_TRUE(loopback);
  const unsigned number = ::if_nametoindex("lo");
  const auto address = boost::asio::ip::make_address("127.0.0.1");
  EXPECT_TRUE(loopback->admits({.interface = number, .address = address}));
  EXPECT_FALSE(loopback->admits({.interface = number + 1, .address = address}));
}

TEST(UdpEntrance, AnAddressAdmitsWhatItsInterfaceBroadcasts) {
  const auto own = UdpEntrance::find("127.0.0.1");
  ASSERT_TRUE(own);
  const unsigned number = ::if_nametoindex("lo");
  // Of a second address of an interface the system names the first one where it was broadcast.
  const auto first = boost::asio::ip::make_address("127.0.0.9");
  EXPECT_TRUE(own->admits({.interface = number, .address = first, .for_several = true}));
  EXPECT_FALSE(own->admits({.interface = number + 1, .address = first, .for_several = true}));
  EXPECT_FALSE(own->admits({.interface = number, .address = first}));
  const auto group = boost::asio::ip::make_address("ff02::1");
  EXPECT_FALSE(own->admits({.interface = number, .address = group, .for_several = true})) << "another family";
}

TEST(UdpEntrance, ALinkLocalAddressIsItsInterfaces) {
  const auto all = network_interfaces();
  const auto one = std::ranges::find_if(all, [](const auto& i) { return i.address.starts_with("fe80:"); });
  if (one == all.end()) GTEST_SKIP() << "this machine has no link-local IPv6 address";
  const unsigned number = ::if_nametoindex(one->name.c_str());
  const auto address = boost::asio::ip::make_address(one->address);
  for (const std::string& name : {one->address, one->address + "%" + one->name}) {
    const auto found = UdpEntrance::find(name);
    ASSERT_TRUE(found) << name;
    EXPECT_EQ(found->name(), name);
    EXPECT_TRUE(found->admits({.interface = number, .address = address})) << name;
    EXPECT_FALSE(found->admits({.interface = number + 1, .address = address})) << name;
  }
  EXPECT_FALSE(UdpEntrance::find(one->address + "%lo")) << "loopback does not have it";
  EXPECT_FALSE(UdpEntrance::find(one->address + "%nosuch0"));
}

}  // namespace
}  // namespace mien::live::listen_only_test
