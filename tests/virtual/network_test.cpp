// The network simulator: what it is told to do to datagrams it does, that often, and nothing else.
#include "mien/virtual/network.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace mien::virt::network_test {
namespace {

using ::testing::HasSubstr;
using Jitter = NetworkSettings::Jitter;

constexpr std::size_t kEach = 20'000;

/// Three nodes, each 60 datagrams a second; the first bytes number them.
std::vector<Datagram> stream() {
  std::vector<Datagram> sent;
  for (std::size_t i = 0; i < kEach; ++i)
    for (std::uint16_t source = 0; source < 3; ++source) {
      Datagram datagram{HostTime(frame_offset(static_cast<std::int64_t>(i)) + Duration(1000 * source)),
                        source, std::vector<std::byte>(60, std::byte{0x33})};
      for (std::size_t k = 0; k < 4; ++k) datagram.bytes[k] = static_cast<std::byte>(i >> (8 * k));
      sent.push_back(std::move(datagram));
    }
  return sent;
}
const std::vector<Datagram>& sent() {
  static const std::vector<Datagram> datagrams = stream();
  return datagrams;
}

std::uint32_t number(const Datagram& datagram) {
  std::uint32_t number = 0;
  for (std::size_t k = 0; k < 4; ++k) number |= std::to_integer<std::uint32_t>(datagram.bytes[k]) << (8 * k);
  return number;
}

std::vector<Datagram> through(const NetworkSettings& settings, std::uint64_t seed = 1) {
  return deliver(sent(), settings, Random(seed)).value();
}

/// Of one source, by number: arrived or not.
std::vector<bool> received(const std::vector<Datagram>& arrived, std::uint16_t source) {
  std::vector<bool> received(kEach, false);
  for (const Datagram& datagram : arrived)
    if (datagram.source == source) received[number(datagram)] = true;
  return received;
}

/// Lengths of the runs of lost datagrams.
std::vector<double> gaps(const std::vector<bool>& received) {
  std::vector<double> lengths;
  double run = 0;
  for (const bool there : received) {
    if (there && run > 0) lengths.push_back(run);
    run = there ? 0 : run + 1;
  }
  return lengths;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

std::vector<double> delays_ms(const std::vector<Datagram>& arrived) {
  std::vector<double> delays;
  for (const Datagram& datagram : arrived)
    delays.push_back(1e3 * to_seconds(datagram.time - sent()[3 * number(datagram) + datagram.source].time));
  return delays;
}

TEST(Network, APerfectOneChangesNothing) {
  const auto arrived = through({});
  ASSERT_EQ(arrived.size(), sent().size());
  for (std::size_t i = 0; i < arrived.size(); ++i) {
    ASSERT_EQ(arrived[i].time, sent()[i].time);
    ASSERT_EQ(arrived[i].source, sent()[i].source);
    ASSERT_EQ(arrived[i].bytes, sent()[i].bytes);
  }
}

TEST(Network, LosesTheShareThatItIsTold) {
  for (const double loss : {0.01, 0.05, 0.2}) {
    const auto arrived = through({.loss = loss});
    const double lost = 1 - static_cast<double>(arrived.size()) / static_cast<double>(sent().size());
    EXPECT_NEAR(lost, loss, 4 * std::sqrt(loss / static_cast<double>(sent().size())));
    // Each by itself: runs are as short as chance makes them.
    EXPECT_NEAR(mean(gaps(received(arrived, 1))), 1 / (1 - loss), 0.05);
  }
}

TEST(Network, BurstsHaveTheirShareAndLength) {
  for (const double length : {1.0, 4.0, 25.0}) {
    const auto arrived = through({.burst_share = 0.1, .burst_length = length});
    const double lost = 1 - static_cast<double>(arrived.size()) / static_cast<double>(sent().size());
    EXPECT_NEAR(lost, 0.1, 0.02) << length;
    const std::vector<double> runs = gaps(received(arrived, 0));
    EXPECT_NEAR(mean(runs), length == 1 ? 1.1 : length, 0.2 * length) << length;
  }
}

TEST(Network, BurstsOfOneSourceAreNotAnothers) {
  const auto arrived = through({.burst_share = 0.1, .burst_length = 20});
  const auto one = received(arrived, 0);
  const auto other = received(arrived, 1);
  double both = 0;
  for (std::size_t i = 0; i < kEach; ++i) both += !one[i] && !other[i] ? 1 : 0;
  EXPECT_NEAR(both / kEach, 0.01, 0.008);
}

TEST(Network, LagIsTheSameForAllAndKeepsTheOrder) {
  const auto arrived = through({.lag_ms = 40});
  for (std::size_t i = 0; i < arrived.size(); ++i)
    ASSERT_EQ(arrived[i].time, sent()[i].time + std::chrono::milliseconds(40));
}

TEST(Network, JitterHasItsMeanAndItsShape) {
  for (const Jitter shape : {Jitter::exponential, Jitter::uniform}) {
    const auto arrived = through({.lag_ms = 5, .jitter_ms = 30, .jitter = shape});
    ASSERT_EQ(arrived.size(), sent().size());
    std::vector<double> delays = delays_ms(arrived);
    EXPECT_NEAR(mean(delays), 35, 0.6);
    std::ranges::sort(delays);
    EXPECT_GE(delays.front(), 5);
    if (shape == Jitter::uniform) {
      EXPECT_LE(delays.back(), 65);
    } else {
      EXPECT_NEAR(delays[delays.size() / 2], 5 + 30 * std::log(2.0), 0.6);
      EXPECT_GT(delays.back(), 200);
    }
  }
}

TEST(Network, WhatArrivesStandsByArrival) {
  const auto arrived =
      through({.loss = 0.1, .burst_share = 0.1, .jitter_ms = 40, .duplicated = 0.1, .corrupted = 0.1});
  EXPECT_TRUE(std::ranges::is_sorted(arrived, {}, &Datagram::time));
}

TEST(Network, DatagramsOvertakeEachOtherOnlyWithJitter) {
  const auto turns = [](const std::vector<Datagram>& arrived) {
    std::array<std::uint32_t, 3> last{};
    std::size_t overtaken = 0;
    for (const Datagram& datagram : arrived) {
      overtaken += number(datagram) < last[datagram.source] ? 1 : 0;
      last[datagram.source] = number(datagram);
    }
    return overtaken;
  };
  EXPECT_GT(turns(through({.jitter_ms = 40})), kEach / 4);
  EXPECT_EQ(turns(through({.lag_ms = 40})), 0U);
}

TEST(Network, DoublesDatagrams) {
  const auto arrived = through({.jitter_ms = 10, .duplicated = 0.05});
  std::map<std::pair<std::uint16_t, std::uint32_t>, int> times;
  for (const Datagram& datagram : arrived) ++times[{datagram.source, number(datagram)}];
  const auto twice = std::ranges::count_if(times, [](const auto& entry) { return entry.second == 2; });
  EXPECT_EQ(times.size(), sent().size());
  EXPECT_NEAR(static_cast<double>(twice) / static_cast<double>(sent().size()), 0.05, 0.005);
}

TEST(Network, ChangesOneToFourBytes) {
  const auto arrived = through({.corrupted = 0.03});
  ASSERT_EQ(arrived.size(), sent().size());
  std::size_t corrupted = 0;
  std::set<int> lengths;
  for (std::size_t i = 0; i < arrived.size(); ++i) {
    ASSERT_EQ(arrived[i].bytes.size(), sent()[i].bytes.size());
    int changed = 0;
    for (std::size_t k = 0; k < arrived[i].bytes.size(); ++k)
      changed += arrived[i].bytes[k] != sent()[i].bytes[k] ? 1 : 0;
    ASSERT_LE(changed, 4);
    if (changed > 0) lengths.insert(changed);
    corrupted += changed > 0 ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(corrupted) / static_cast<double>(sent().size()), 0.03, 0.004);
  EXPECT_EQ(lengths, (std::set<int>{1, 2, 3, 4}));
}

TEST(Network, CutsDatagramsShort) {
  const auto arrived = through({.truncated = 0.03});
  ASSERT_EQ(arrived.size(), sent().size());
  std::size_t cut = 0;
  std::set<std::size_t> sizes;
  for (std::size_t i = 0; i < arrived.size(); ++i) {
    const auto& bytes = arrived[i].bytes;
    ASSERT_TRUE(std::equal(bytes.begin(), bytes.end(), sent()[i].bytes.begin()));
    if (bytes.size() == 60) continue;
    ++cut;
    sizes.insert(bytes.size());
  }
  EXPECT_NEAR(static_cast<double>(cut) / static_cast<double>(sent().size()), 0.03, 0.004);
  EXPECT_EQ(sizes.size(), 60U);  // Of all lengths from none to all but one.
}

TEST(Network, TheSeedDecidesAll) {
  const NetworkSettings settings{.loss = 0.05,
                                 .burst_share = 0.05,
                                 .jitter_ms = 20,
                                 .duplicated = 0.05,
                                 .corrupted = 0.05,
                                 .truncated = 0.05};
  const auto one = through(settings, 3);
  const auto same = through(settings, 3);
  const auto other = through(settings, 4);
  ASSERT_EQ(one.size(), same.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].time, same[i].time);
    ASSERT_EQ(one[i].bytes, same[i].bytes);
  }
  EXPECT_NE(one.front().time, other.front().time);
}

TEST(Network, OneFaultLeavesTheOthersAsTheyWere) {
  const auto calm = through({.jitter_ms = 20});
  const auto lossy = through({.loss = 0.2, .jitter_ms = 20, .corrupted = 0.1});
  std::map<std::pair<std::uint16_t, std::uint32_t>, HostTime> times;
  for (const Datagram& datagram : calm) times[{datagram.source, number(datagram)}] = datagram.time;
  std::size_t same = 0;
  for (const Datagram& datagram : lossy) {
    const auto found = times.find({datagram.source, number(datagram)});
    same += found != times.end() && found->second == datagram.time ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(same), 0.97 * static_cast<double>(lossy.size()));  // Corrupt numbers aside.
}

TEST(Network, NothingSentNothingHeard) {
  EXPECT_TRUE(deliver({}, {.loss = 0.1}, Random(1)).value().empty());
  EXPECT_TRUE(through({.loss = 1}).empty());
}

TEST(Network, EachWrongSettingIsNamed) {
  const auto refused = [](const NetworkSettings& settings, const char* name) {
    const auto arrived = deliver(sent(), settings, Random(1));
    ASSERT_FALSE(arrived) << name;
    EXPECT_EQ(arrived.error().code, ErrorCode::out_of_range);
    EXPECT_THAT(arrived.error().message(), HasSubstr(name));
  };
  const double nan = std::nan("");
  refused({.loss = -0.1}, "loss");
  refused({.loss = 1.1}, "loss");
  refused({.loss = nan}, "loss");
  refused({.burst_share = 1}, "burst_share");
  refused({.burst_share = 0.1, .burst_length = 0.5}, "burst_length");
  refused({.lag_ms = -1}, "lag_ms");
  refused({.lag_ms = 1e9}, "lag_ms");
  refused({.jitter_ms = nan}, "jitter_ms");
  refused({.duplicated = 2}, "duplicated");
  refused({.corrupted = -1}, "corrupted");
  refused({.truncated = 1.5}, "truncated");
}

}  // namespace
}  // namespace mien::virt::network_test
