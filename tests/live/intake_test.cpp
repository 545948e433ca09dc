#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/intake.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "tests/allocation_count.h"
#include "tests/live/page_client.h"

namespace mien::live::intake_test {
namespace {

using boost::asio::ip::udp;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// An intake on a port of its own, with a clock that stands still until it is told to go on.
class IntakeTest : public ::testing::Test {
 protected:
  IntakeTest() {
    const auto listening = intake.listen("udp://127.0.0.1:0");
    EXPECT_TRUE(listening) << listening.error().message();
    there = {boost::asio::ip::address_v4::loopback(), test::port_of(*listening)};
  }

  udp::socket somebody() { return {network, {boost::asio::ip::address_v4::loopback(), 0}}; }
  /// Sends, and lets it come in: on this machine's own loopback it is there when send returns.
  void send(udp::socket& from, const std::string& text) {
    from.send_to(boost::asio::buffer(text), there);
    const std::uint64_t before = intake.counts().received;
    EXPECT_TRUE(test::run_until(network, [&] { return intake.counts().received > before; }));
  }
  enum class Standing : std::uint8_t { stranger, bound };
  /// Takes all that is there as the tracker's thread does, and judges it.
  std::vector<std::string> take(Standing standing) {
    std::vector<std::string> texts;
    while (const auto arrived = intake.front()) {
      texts.emplace_back(reinterpret_cast<const char*>(arrived->bytes.data()), arrived->bytes.size());
      last = arrived->peer;
      if (standing == Standing::bound) intake.judge_bound();
      names[last] = arrived->source;
      intake.release();
    }
    return texts;
  }

  boost::asio::io_context network;
  HostTime now{};
  Intake intake{network, [this] { return now; }};
  udp::endpoint there;
  sensor::Peer last = 0;
  std::map<sensor::Peer, std::string> names;
};

TEST_F(IntakeTest, HandsOverInOrderWithArrivalAndPeer) {
  udp::socket one = somebody(), two = somebody();
  now = HostTime(std::chrono::seconds(3));
  send(one, "a");
  send(two, "");
  EXPECT_TRUE(intake.command(7, 9, "{}"));
  const auto first = intake.front();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->kind, Arrived::Kind::datagram);
  EXPECT_EQ(first->arrival, now);
  EXPECT_EQ(first->bytes.size(), 1u);
  EXPECT_EQ(first->source, "udp://127.0.0.1:" + std::to_string(one.local_endpoint().port()));
  const sensor::Peer peer = first->peer;
  intake.release();
  const auto second = intake.front();
  ASSERT_TRUE(second);
  EXPECT_NE(second->peer, peer);
  EXPECT_TRUE(second->bytes.empty());
  intake.release();
  const auto third = intake.front();
  ASSERT_TRUE(third);
  EXPECT_EQ(third->kind, Arrived::Kind::command);
  EXPECT_EQ(third->client, 7u);
  EXPECT_EQ(third->number, 9);
  intake.release();
  EXPECT_FALSE(intake.front());

  // And back.
  const std::array<std::byte, 3> answer{};
  intake.send(peer, answer);
  std::array<std::byte, 16> received{};
  EXPECT_EQ(one.receive(boost::asio::buffer(received)), 3u);
  intake.send(250, answer);  // Nobody.
}

TEST_F(IntakeTest, HoldsASenderToItsRateAndNobodyElse) {
  udp::socket fast = somebody(), calm = somebody();
  const auto most = static_cast<std::size_t>(Intake::kMaxRatePerPeer);
  for (std::size_t i = 0; i < most + 50; ++i) send(fast, "x");
  send(calm, "y");
  EXPECT_EQ(intake.counts().too_fast, 50u);
  EXPECT_EQ(take(Standing::bound).size(), most + 1);
  now += std::chrono::milliseconds(100);
  for (int i = 0; i < 150; ++i) send(fast, "x");
  EXPECT_EQ(intake.counts().too_fast, 100u) << "a tenth of a second is worth a hundred";
  // Who it was can be told.
  std::vector<Intake::FastSender> fast_ones;
  intake.fast_senders(fast_ones);
  ASSERT_EQ(fast_ones.size(), 1u);
  EXPECT_EQ(fast_ones[0].source, "udp://127.0.0.1:" + std::to_string(fast.local_endpoint().port()));
  EXPECT_EQ(fast_ones[0].sent, most + 200);
  EXPECT_EQ(fast_ones[0].dropped, 100u);
}

TEST_F(IntakeTest, KnowsWhomItHearsNow) {
  const auto here = boost::asio::ip::make_address("127.0.0.1");
  EXPECT_FALSE(intake.hears(here, std::chrono::seconds(1)));
  udp::socket one = somebody();
  send(one, "x");
  now += std::chrono::milliseconds(900);
  EXPECT_TRUE(intake.hears(here, std::chrono::seconds(1)));
  EXPECT_FALSE(intake.hears(boost::asio::ip::make_address("127.0.0.2"), std::chrono::seconds(1)));
  now += std::chrono::milliseconds(200);
  EXPECT_FALSE(intake.hears(here, std::chrono::seconds(1)));
  take(Standing::stranger);
}

TEST_F(IntakeTest, AClockThatBeginsAnewCostsNothing) {
  udp::socket one = somebody();
  now = HostTime(std::chrono::seconds(60));
  send(one, "a");
  now = HostTime();
  send(one, "b");
  EXPECT_EQ(intake.counts().too_fast, 0u);
}

TEST_F(IntakeTest, DropsAndCountsWhatIsTooLongOrTooMuch) {
  udp::socket one = somebody();
  send(one, std::string(Intake::kMaxDatagram + 1, 'x'));
  EXPECT_EQ(intake.counts().too_long, 1u);
  EXPECT_FALSE(intake.front());
  send(one, std::string(Intake::kMaxDatagram, 'x'));
  EXPECT_EQ(take(Standing::bound).size(), 1u);
  // Nobody takes: two megabytes wait, and the rest is dropped.
  for (int second = 0; second < 3; ++second, now += std::chrono::seconds(1))
    for (int i = 0; i < 900; ++i) send(one, std::string(Intake::kMaxDatagram, 'x'));
  EXPECT_GT(intake.counts().overrun, 0u);
  EXPECT_EQ(take(Standing::bound).size() + intake.counts().overrun, 2700u);
}

TEST_F(IntakeTest, CountsWhatTheKernelHadNoRoomFor) {
  udp::socket one = somebody();
  // Nobody runs the network: the socket's buffer, of a megabyte or what the system allows, fills.
  const std::string text(1400, 'x');
  for (int i = 0; i < 6000; ++i) one.send_to(boost::asio::buffer(text), there);
  EXPECT_GT(intake.counts().kernel_dropped, 0u);
  EXPECT_EQ(intake.counts().received, 0u);
}

TEST_F(IntakeTest, HoldsStrangersToABudgetOfTheirOwn) {
  udp::socket device = somebody();
  send(device, "reading");
  take(Standing::bound);
  // Of one address, whatever its ports: beyond its budget they are dropped, and devices are not.
  std::vector<udp::socket> strangers;
  for (int i = 0; i < 20; ++i) strangers.push_back(somebody());
  for (int i = 0; i < 2000; ++i) send(strangers[static_cast<std::size_t>(i % 20)], "junk");
  const auto most = static_cast<std::size_t>(Intake::kMaxRatePerHost) - 1;
  EXPECT_EQ(take(Standing::stranger).size(), most);
  EXPECT_EQ(intake.counts().too_fast, 2000 - most);
  send(device, "reading");
  EXPECT_EQ(take(Standing::bound).size(), 1u);
}

TEST_F(IntakeTest, AFloodBeyondItsBudgetCostsNoMemoryWhateverTheAddressIs) {
  const auto listening = intake.listen("udp://[::]:0");
  if (!listening) GTEST_SKIP() << "no IPv6 here: " << listening.error().message();
  // From an IPv6 address whose text is long.
  const auto port = static_cast<std::uint16_t>(std::stoi(listening->substr(listening->rfind(':') + 1)));
  there = {boost::asio::ip::make_address("::ffff:127.0.0.1"), port};
  std::vector<udp::socket> strangers;
  for (int i = 0; i < 4; ++i) strangers.emplace_back(network, udp::v6());
  // Beyond the budget of the address, and none beyond that of a sender.
  const auto say = [&](std::size_t i) { strangers[i % 4].send_to(boost::asio::buffer("junk", 4), there); };
  const auto most = static_cast<std::size_t>(Intake::kMaxRatePerHost);
  for (std::size_t i = 0; i < most + 4; ++i) send(strangers[i % 4], "junk");
  const std::uint64_t too_fast = intake.counts().too_fast;
  ASSERT_GT(too_fast, 0u);
  for (std::size_t i = 0; i < 500; ++i) say(i);
  const std::size_t before = mien::test::allocation_count();
  while (intake.counts().too_fast < too_fast + 500) network.poll_one();
  EXPECT_EQ(mien::test::allocation_count(), before);
}

TEST_F(IntakeTest, StrangersKeepNoDeviceOutOfTheTable) {
  udp::socket device = somebody();
  send(device, "reading");
  take(Standing::bound);
  const sensor::Peer peer = last;
  // Nobody knows yet what these are: none has to go, and whoever comes then is too many.
  std::vector<udp::socket> strangers;
  for (std::size_t i = 1; i < Intake::kMaxPeers; ++i) send(strangers.emplace_back(somebody()), "hello");
  udp::socket late = somebody();
  send(late, "reading");
  EXPECT_EQ(intake.counts().too_many, 1u);
  EXPECT_EQ(intake.counts().evicted, 0u);
  // They were understood, and none is bound: who was silent longest gives way, and then the next.
  EXPECT_EQ(take(Standing::stranger).size(), Intake::kMaxPeers - 1);
  now += std::chrono::seconds(1);
  send(late, "reading");
  EXPECT_EQ(intake.counts().evicted, 1u);
  EXPECT_EQ(take(Standing::bound), std::vector<std::string>{"reading"});
  const sensor::Peer late_peer = last;
  EXPECT_GE(late_peer, Intake::kMaxPeers) << "a number of its own";
  EXPECT_EQ(names[late_peer], "udp://127.0.0.1:" + std::to_string(late.local_endpoint().port()) + "#" +
                                  std::to_string(late_peer));
  for (std::size_t i = 0; i < 2 * Intake::kMaxPeers; ++i) {
    now += std::chrono::milliseconds(5);
    udp::socket stranger = somebody();
    send(stranger, "hello");
    take(Standing::stranger);
  }
  EXPECT_EQ(intake.counts().too_many, 1u);
  // Who is bound is still who it was.
  send(device, "reading");
  EXPECT_EQ(take(Standing::bound), std::vector<std::string>{"reading"});
  EXPECT_EQ(last, peer);
  send(late, "reading");
  take(Standing::bound);
  EXPECT_EQ(last, late_peer);
  // Every sender of the log has a name of its own.
  std::set<std::string> different;
  for (const auto& named : names) different.insert(named.second);
  EXPECT_EQ(different.size(), names.size());
}

TEST_F(IntakeTest, ASenderIsNotForgottenBeforeWhatItSentWasTaken) {
  std::vector<udp::socket> strangers;
  for (std::size_t i = 0; i < Intake::kMaxPeers; ++i) send(strangers.emplace_back(somebody()), "hello");
  now += std::chrono::seconds(1);
  udp::socket late = somebody();
  send(late, "reading");
  EXPECT_EQ(intake.counts().too_many, 1u);
  EXPECT_EQ(take(Standing::stranger).size(), Intake::kMaxPeers);
  send(late, "reading");
  EXPECT_EQ(intake.counts().too_many, 1u);
  EXPECT_EQ(take(Standing::stranger).size(), 1u);
}

TEST_F(IntakeTest, ATableOfDevicesTakesNoMoreUntilOneWasSilentForLong) {
  std::vector<udp::socket> devices;
  for (std::size_t i = 0; i < Intake::kMaxPeers; ++i) {
    send(devices.emplace_back(somebody()), "reading");
    take(Standing::bound);
  }
  udp::socket late = somebody();
  send(late, "reading");
  EXPECT_FALSE(intake.front());
  EXPECT_EQ(intake.counts().too_many, 1u);
  EXPECT_EQ(intake.counts().evicted, 0u);
  now += Intake::kForget + std::chrono::seconds(1);
  send(late, "reading");
  EXPECT_EQ(take(Standing::bound).size(), 1u);
}

TEST_F(IntakeTest, SaysWhatIsWrongWithAnAddress) {
  for (const char* address : {"", "127.0.0.1", "udp://127.0.0.1", "tcp://127.0.0.1:1",
                              "udp://127.0.0.1:99999", "udp://127.0.0.1:", "udp://somebody:5005",
                              "udp://[::1:5005", "udp://::1:5005", "udp://203.0.113.1:5005"}) {
    const auto listening = intake.listen(address);
    ASSERT_FALSE(listening) << address;
    EXPECT_EQ(listening.error().code, ErrorCode::bad_usage) << address;
  }
  const auto taken = intake.listen("udp://127.0.0.1:" + std::to_string(there.port()));
  ASSERT_FALSE(taken);
  EXPECT_THAT(taken.error().message(), HasSubstr("another program"));
  EXPECT_THAT(intake.listen("localhost:0").value(), StartsWith("udp://127.0.0.1:"));
}

}  // namespace
}  // namespace mien::live::intake_test
