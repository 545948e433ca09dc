#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/fast_sender_news.h"

#include <gmock/gmock.h>

#include <string>
#include <vector>

namespace mien::live::fast_sender_news_test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

/// Senders with rates, and what is said of them at ten looks a second.
class Floods {
 public:
  /// Goes on for so long, each sender at its rate, 1/s.
  std::vector<Sentence> go_on(double seconds, const std::vector<double>& rates_hz) {
    sent_.resize(rates_hz.size());
    dropped_.resize(rates_hz.size());
    std::vector<Sentence> said;
    for (int look = 0; look < 10 * seconds; ++look) {
      now_ += std::chrono::milliseconds(100);
      std::vector<Intake::FastSender> fast;
      for (std::size_t i = 0; i < rates_hz.size(); ++i) {
        sent_[i] += rates_hz[i] / 10;
        dropped_[i] += std::max(0.0, rates_hz[i] - Intake::kMaxRatePerPeer) / 10;
        if (dropped_[i] > 0)
          fast.push_back({.peer = static_cast<sensor::Peer>(i),
                          .source = kNames[i],
                          .sent = static_cast<std::uint64_t>(sent_[i]),
                          .dropped = static_cast<std::uint64_t>(dropped_[i])});
      }
      for (auto& one : news_.tell(now_, fast)) said.push_back(std::move(one));
    }
    return said;
  }

 private:
  static constexpr std::array<std::string_view, 4> kNames = {"udp://192.168.1.7:5005", "serial:/dev/ttyUSB0",
                                                             "udp://[fe80::1]:9", "udp://10.0.0.1:1"};
  FastSenderNews news_;
  HostTime now_;
  std::vector<double> sent_, dropped_;
};

TEST(FastSenderNews, SaysOnceThatOneBeginsAndOnceThatItIsOver) {
  Floods floods;
  EXPECT_THAT(floods.go_on(5, {900}), IsEmpty());
  const auto begun = floods.go_on(60, {1987});
  ASSERT_THAT(begun, SizeIs(1));
  EXPECT_EQ(begun[0].kind, "packets_lost");
  EXPECT_THAT(begun[0].text, StartsWith("udp://192.168.1.7:5005 sends 1990 packets a second"));
  EXPECT_THAT(begun[0].text, HasSubstr("lower the rate"));
  const auto over = floods.go_on(60, {300});
  ASSERT_THAT(over, SizeIs(1));
  EXPECT_EQ(over[0].kind, "packets_taken");
  EXPECT_EQ(over[0].text, "udp://192.168.1.7:5005 sends no more than 1000 packets a second again");
}

TEST(FastSenderNews, SaysNothingOfOneBurst) {
  Floods floods;
  EXPECT_THAT(floods.go_on(0.1, {15'000}), IsEmpty());
  EXPECT_THAT(floods.go_on(30, {300}), IsEmpty());
}

TEST(FastSenderNews, OfOneThatFloodsByTurnsSaysLittle) {
  Floods floods;
  std::vector<Sentence> said;
  for (int turn = 0; turn < 10; ++turn) {
    for (auto& one : floods.go_on(3, {3000})) said.push_back(std::move(one));
    for (auto& one : floods.go_on(6, {0})) said.push_back(std::move(one));
  }
  EXPECT_LE(said.size(), 20u);
  // Each of the two by turns.
  for (std::size_t i = 0; i < said.size(); ++i)
    EXPECT_EQ(said[i].kind, i % 2 == 0 ? "packets_lost" : "packets_taken") << i;
}

TEST(FastSenderNews, SaysSeveralInOneSentence) {
  Floods floods;
  const auto begun = floods.go_on(20, {1200, 12'345, 4000, 2000});
  ASSERT_THAT(begun, SizeIs(1));
  EXPECT_THAT(begun[0].text,
              StartsWith("udp://192.168.1.7:5005 and 3 more send too many packets, that one 1200"));
  EXPECT_THAT(floods.go_on(20, {1, 1, 1, 1}), SizeIs(1));
  EXPECT_THAT(floods.go_on(20, {1, 2000, 1, 2000}), SizeIs(2));
}

TEST(FastSenderNews, OfOneWhosePlaceIsAnothersItIsOver) {
  FastSenderNews news;
  HostTime now;
  std::vector<Intake::FastSender> fast = {{.peer = 7, .source = "udp://10.0.0.1:1", .sent = 0, .dropped = 1}};
  std::size_t said = 0;
  for (int i = 0; i < 20; ++i) {
    now += std::chrono::milliseconds(200);
    fast[0].sent += 1000;
    fast[0].dropped += 800;
    said += news.tell(now, fast).size();
  }
  EXPECT_EQ(said, 1u);
  const auto over = news.tell(now, {});
  ASSERT_THAT(over, SizeIs(1));
  EXPECT_EQ(over[0].kind, "packets_taken");
}

}  // namespace
}  // namespace mien::live::fast_sender_news_test
