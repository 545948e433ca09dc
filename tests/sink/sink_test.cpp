#include "mien/sink/sink.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mien/core/files.h"
#include "tests/folder.h"
#include "tests/sink/loopback.h"

namespace mien::sink::sink_test {
namespace {

using ::testing::HasSubstr;

TEST(Sink, LiveLinkReachesAReceiver) {
  boost::asio::io_context network;
  test::Receiver receiver(network);
  auto sink = open_sink(network, fmt::format("livelink://127.0.0.1:{}?subject=face", receiver.port()));
  ASSERT_TRUE(sink) << sink.error().message();
  for (int i = 0; i < 60; ++i) (*sink)->send({}, i);
  const auto packets = receiver.take();
  ASSERT_EQ(packets.size(), 60u);
  EXPECT_EQ(packets[0].size(), 310u);
  const Status status = (*sink)->status();
  EXPECT_EQ(status.sent, 60u);
  EXPECT_EQ(status.failed, 0u);
  EXPECT_EQ(status.rate_hz, 60);
  EXPECT_EQ(status.receivers, std::nullopt);
  EXPECT_EQ(status.note, "");
}

TEST(Sink, HasARateOfItsOwn) {
  boost::asio::io_context network;
  test::Receiver receiver(network);
  auto sink = open_sink(network, fmt::format("livelink://127.0.0.1:{}?rate=24", receiver.port()));
  ASSERT_TRUE(sink) << sink.error().message();
  for (int i = 1000; i < 1600; ++i) (*sink)->send({}, i);
  EXPECT_EQ(receiver.take().size(), 240u);
  EXPECT_EQ((*sink)->status().rate_hz, 24);
}

TEST(Sink, ADeadReceiverHurtsNobody) {
  boost::asio::io_context network;
  std::uint16_t dead = 0;
  {
    test::Receiver gone(network);
    dead = gone.port();
  }
  test::Receiver receiver(network);
  auto bad = open_sink(network, fmt::format("livelink://127.0.0.1:{}", dead));
  auto good = open_sink(network, fmt::format("livelink://127.0.0.1:{}", receiver.port()));
  ASSERT_TRUE(bad && good);
  for (int i = 0; i < 60; ++i) {
    (*bad)->send({}, i);
    (*good)->send({}, i);
  }
  EXPECT_EQ(receiver.take().size(), 60u);
  const Status status = (*bad)->status();
  // The refusal of the last has nobody to tell yet.
  EXPECT_EQ(status.sent, 1u);
  EXPECT_EQ(status.failed, 59u);
  EXPECT_EQ(status.receivers, 0u);
  EXPECT_THAT(status.note, HasSubstr("nobody listens"));
}

TEST(Sink, SeveralGoOnAtOnce) {
  boost::asio::io_context network;
  test::Receiver live_link(network);
  test::Receiver vmc(network);
  test::Receiver vrchat(network);
  const auto open = [&](const char* form, test::Receiver& to) {
    auto sink = open_sink(network, fmt::format(fmt::runtime(form), to.port()));
    EXPECT_TRUE(sink) << sink.error().message();
    return *std::move(sink);
  };
  const auto one = open("livelink://127.0.0.1:{}", live_link);
  const auto two = open("vmc://127.0.0.1:{}?rate=30&shapes=arkit", vmc);
  const auto three = open("vrchat://127.0.0.1:{}?rate=10", vrchat);
  for (int i = 0; i < 120; ++i)
    for (const auto& sink : {one.get(), two.get(), three.get()}) sink->send({}, i);
  EXPECT_EQ(live_link.take().size(), 120u);
  EXPECT_EQ(vmc.take().size(), 180u);  // Three bundles a frame.
  EXPECT_GT(vrchat.take().size(), 5u);
  EXPECT_EQ(two->status().sent, 60u);
  EXPECT_EQ(three->status().sent, 20u);
  EXPECT_EQ(three->status().rate_hz, 10);
}

/// A receiver that does not read: what its machine has no room for is lost there, and we do not wait.
TEST(Sink, ASlowReceiverIsNotWaitedFor) {
  boost::asio::io_context network;
  test::Receiver receiver(network);
  receiver.socket().set_option(boost::asio::socket_base::receive_buffer_size(4096));
  auto sink = open_sink(network, fmt::format("vmc://127.0.0.1:{}", receiver.port()));
  ASSERT_TRUE(sink);
  for (int i = 0; i < 5000; ++i) (*sink)->send({}, i);
  EXPECT_EQ((*sink)->status().sent + (*sink)->status().failed, 5000u);
  EXPECT_LT(receiver.take().size(), 100u);
}

/// Several are given: an error says which it was, whatever is wrong with it.
TEST(Sink, ErrorsNameTheAddress) {
  boost::asio::io_context network;
  const mien::test::Folder folder;
  for (const std::string& address :
       {std::string("fax://127.0.0.1"), std::string("livelink:127.0.0.1"), std::string("livelink://"),
        std::string("livelink://127.0.0.1:99999"), std::string("livelink://no.such.invalid"),
        std::string("livelink://127.0.0.1?subject="), std::string("vmc://127.0.0.1?shapes=round"),
        std::string("vmc://127.0.0.1?rate=often"), std::string("vmc://127.0.0.1?rate=999"),
        std::string("vmc://127.0.0.1?speed=1"), std::string("vmc://127.0.0.1?=1"),
        std::string("vrchat://127.0.0.1?avatar=/no/such.json"), std::string("ws://no.such.invalid"),
        std::string("ws://203.0.113.1:8741?role=listen"), std::string("ws://127.0.0.1?role=dance"),
        std::string("csv:") + (folder / "no/such.csv").string()}) {
    const auto refused = open_sink(network, address);
    ASSERT_FALSE(refused) << address;
    EXPECT_EQ(refused.error().where, address);
    EXPECT_EQ(refused.error().what.find(address), std::string::npos) << refused.error().what;
  }
  EXPECT_THAT(open_sink(network, "vrchat://127.0.0.1?avatar=/no/such.json").error().message(),
              HasSubstr("/no/such.json"));
  const std::string bell = "livelink://\a";
  EXPECT_EQ(open_sink(network, bell).error().message().find('\a'), std::string::npos);
}

TEST(Sink, VrchatTakesAnAvatarsFile) {
  const mien::test::Folder folder;
  const auto path = folder / "fox avatar.json";
  ASSERT_TRUE(write_file(path, R"({"id": "a", "name": "Fox", "parameters": [
    {"name": "JawOpen", "input": {"address": "/avatar/parameters/v2/JawOpen", "type": "Float"}}]})"));
  boost::asio::io_context network;
  test::Receiver receiver(network);
  const std::string file = (folder / "fox%20avatar.json").string();
  auto sink =
      open_sink(network, fmt::format("vrchat://127.0.0.1:{}?avatar={}&eyes=0", receiver.port(), file));
  ASSERT_TRUE(sink) << sink.error().message();
  (*sink)->send({}, 0);
  const auto packets = receiver.take();
  ASSERT_EQ(packets.size(), 1u);
  EXPECT_EQ(packets[0].size(), 60u);
  EXPECT_FALSE(open_sink(network, fmt::format("vrchat://127.0.0.1?avatar={}&binary=2", file)));
  EXPECT_EQ(open_sink(network, "vrchat://127.0.0.1?avatar=/no/such.json").error().code, ErrorCode::not_found);
  EXPECT_FALSE(open_sink(network, "vrchat://127.0.0.1?binary=9"));
}

TEST(Sink, ReachesIpv6AndNames) {
  boost::asio::io_context network;
  auto name = open_sink(network, "livelink://localhost:9");
  EXPECT_TRUE(name) << name.error().message();
  auto number = open_sink(network, "livelink://[::1]:9");
  if (!number) GTEST_SKIP() << "no IPv6 here: " << number.error().message();
}

TEST(Sink, SaysInOneLineWhatIsWrong) {
  boost::asio::io_context network;
  const auto error = [&](std::string_view address) {
    const auto sink = open_sink(network, address);
    EXPECT_FALSE(sink) << address;
    return sink ? std::string() : sink.error().message();
  };
  EXPECT_THAT(
      error("osc://127.0.0.1:9000"),
      HasSubstr("livelink://HOST:PORT, vmc://HOST:PORT, vrchat://HOST:PORT, ifacialmocap://HOST:PORT, "
                "ws://HOST:PORT, csv:FILE"));
  EXPECT_THAT(error("vmc://127.0.0.1?shapes=all"), HasSubstr("arkit, presets or both"));
  EXPECT_THAT(error("livelink://127.0.0.1?rate=90"), HasSubstr("1 to 60"));
  EXPECT_THAT(error("livelink://127.0.0.1?colour=red"), HasSubstr("subject, rate"));
  EXPECT_THAT(error("livelink://127.0.0.1/path"), HasSubstr("no path"));
  EXPECT_THAT(error("livelink://127.0.0.1?subject="), HasSubstr("1 to 255"));
  EXPECT_THAT(error("livelink://no-such-host.invalid"), HasSubstr("not found"));
}

}  // namespace
}  // namespace mien::sink::sink_test
