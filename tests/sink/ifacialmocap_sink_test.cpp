#include "mien/sink/sink_kinds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sink/loopback.h"

namespace mien::sink::ifacialmocap_sink_test {
namespace {

using boost::asio::ip::udp;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::string kRequest = "iFacialMocap_sahuasouryya9218sauhuiayeta91555dy3719";

/// A port that is free for both kinds of address of this machine's loopback net.
std::uint16_t free_udp_port() {
  boost::asio::io_context network;
  return udp::socket(network, {udp::v4(), 0}).local_endpoint().port();
}

TEST(IFacialMocapSink, SendsUnasked) {
  boost::asio::io_context network;
  test::Receiver receiver(network);
  auto v2 = open_sink(network, fmt::format("ifacialmocap://127.0.0.1:{}", receiver.port()));
  auto v1 = open_sink(network, fmt::format("ifacialmocap://127.0.0.1:{}?version=1&rate=30", receiver.port()));
  ASSERT_TRUE(v2 && v1);
  for (int i = 0; i < 60; ++i) (*v2)->send({}, i);
  auto packets = receiver.take();
  ASSERT_EQ(packets.size(), 60u);
  EXPECT_THAT(packets[0], StartsWith("trackingStatus&1|eyeBlink_L&0|"));
  for (int i = 0; i < 60; ++i) (*v1)->send({}, i);
  packets = receiver.take();
  ASSERT_EQ(packets.size(), 30u);
  EXPECT_THAT(packets[0], StartsWith("eyeBlink_L-0|"));
  EXPECT_EQ((*v1)->status().rate_hz, 30);
  EXPECT_EQ((*v1)->status().receivers, std::nullopt);
  EXPECT_EQ((*v1)->status().note, "");
}

/// The receiver that is named stands at 127.0.0.1, another that asks at 127.0.0.2; both listen on one port.
TEST(IFacialMocapSink, AnswersWhoAsks) {
  boost::asio::io_context network;
  test::Receiver named(network);
  const auto port = named.port();
  udp::socket asking(network, {boost::asio::ip::make_address_v4("127.0.0.2"), port});
  asking.non_blocking(true);
  const auto requests = free_udp_port();
  auto sink = open_sink(network, fmt::format("ifacialmocap://127.0.0.1:{}?listen={}", port, requests));
  ASSERT_TRUE(sink) << sink.error().message();
  const udp::endpoint phone(boost::asio::ip::address_v4::loopback(), requests);
  const auto ask = [&](const std::string& text) { asking.send_to(boost::asio::buffer(text), phone); };
  const auto answer = [&] {
    std::string packet(2048, '\0');
    boost::system::error_code code;
    packet.resize(asking.receive(boost::asio::buffer(packet), 0, code));
    return packet;
  };
  ask("hello");
  (*sink)->send({}, 0);
  EXPECT_EQ(answer(), "");
  EXPECT_EQ((*sink)->status().receivers, std::nullopt);
  ask(kRequest);
  (*sink)->send({}, 1);
  EXPECT_THAT(answer(), StartsWith("eyeBlink_L-0|"));
  EXPECT_EQ((*sink)->status().receivers, 2u);
  ask(kRequest + "|sendDataVersion=v2");
  (*sink)->send({}, 2);
  EXPECT_THAT(answer(), StartsWith("trackingStatus&1|"));
  EXPECT_EQ((*sink)->status().receivers, 2u);
  EXPECT_EQ(named.take().size(), 3u);

  ask("iFacialMocap_UDPTCP_" + kRequest.substr(13));
  (*sink)->send({}, 3);
  EXPECT_THAT((*sink)->status().note, HasSubstr("TCP"));

  // Who has gone is not sent to for ever.
  asking.close();
  for (int i = 4; i < 400; ++i) (*sink)->send({}, i);
  EXPECT_EQ((*sink)->status().receivers, std::nullopt);
  EXPECT_EQ((*sink)->status().failed, 0u);
}

TEST(IFacialMocapSink, SaysWhenItCannotListen) {
  boost::asio::io_context network;
  test::Receiver receiver(network);
  const auto refused =
      open_sink(network, fmt::format("ifacialmocap://127.0.0.1:9?listen={}", receiver.port()));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::io);
  EXPECT_FALSE(open_sink(network, "ifacialmocap://127.0.0.1?version=3"));
}

}  // namespace
}  // namespace mien::sink::ifacialmocap_sink_test
