#include "mien/sensor/arrival_hold.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <vector>

#include "mien/core/random.h"

namespace mien::sensor::arrival_hold_test {
namespace {

constexpr Duration kMs = std::chrono::milliseconds(1);

/// 60 packets a second of each sensor, the lateness of each as it is given.
using Lateness = std::function<Duration(std::size_t sensor, double t, Random& random)>;

struct Network {
  explicit Network(std::size_t count) : sensors(count), hold(count), random(1) {}
  /// Goes on with what is sent until `end_s`.
  void run(double end_s, const Lateness& lateness) {
    struct Packet {
      HostTime arrival;
      std::uint16_t sensor;
      std::uint32_t sequence;
      Duration late;
    };
    std::vector<Packet> packets;
    for (; t < end_s; t += 1 / 60.0, ++sequence)
      for (std::size_t s = 0; s < sensors; ++s) {
        const Duration late = lateness(s, t, random);
        packets.push_back({HostTime(from_seconds(t)) + late, static_cast<std::uint16_t>(s), sequence, late});
      }
    std::ranges::sort(packets, {},
                      [](const Packet& p) { return std::tuple(p.arrival, p.sequence, p.sensor); });
    for (const Packet& packet : packets) {
      // A packet's samples come together; the newest of them is the least late.
      hold.add(packet.sensor, packet.sequence, packet.arrival, packet.late + 12 * kMs);
      hold.add(packet.sensor, packet.sequence, packet.arrival, packet.late);
      longest = std::max(longest, hold.now());
    }
  }
  std::size_t sensors;
  ArrivalHold hold;
  Random random;
  double t = 0;
  std::uint32_t sequence = 0;
  Duration longest{};
};

Duration exponential(Random& random, double mean_ms) {
  return from_seconds(1e-3 * random.exponential(mean_ms));
}

TEST(ArrivalHold, IsZeroForAGoodRadio) {
  Network network(12);
  network.run(120, [](std::size_t, double, Random& random) { return exponential(random, 4); });
  EXPECT_EQ(network.longest, Duration::zero());
  EXPECT_EQ(network.hold.longest(), Duration::zero());
}

TEST(ArrivalHold, IsZeroForStalls) {
  // Every five seconds nothing comes for 200 ms, and then all at once.
  Network network(12);
  network.run(60, [](std::size_t, double t, Random& random) {
    const double since = std::fmod(t, 5.0);
    return since < 0.2 ? from_seconds(0.2 - since) : exponential(random, 4);
  });
  EXPECT_EQ(network.longest, Duration::zero());
}

TEST(ArrivalHold, RisesWithinASecondAndFallsSlowly) {
  Network network(12);
  network.run(10, [](std::size_t, double, Random& random) { return exponential(random, 4); });
  const auto jitter = [](std::size_t, double, Random& random) {
    return from_seconds(random.uniform(0, 0.04));
  };
  network.run(11, jitter);
  EXPECT_GE(network.hold.now(), 36 * kMs);
  EXPECT_LE(network.hold.now(), 44 * kMs);
  network.run(20, jitter);
  const Duration before = network.hold.now();
  network.run(25, [](std::size_t, double, Random& random) { return exponential(random, 4); });
  EXPECT_LT(network.hold.now(), before - 15 * kMs);
  EXPECT_GT(network.hold.now(), before - 26 * kMs);
  network.run(32, [](std::size_t, double, Random& random) { return exponential(random, 4); });
  EXPECT_EQ(network.hold.now(), Duration::zero());
  EXPECT_EQ(network.hold.longest(), network.longest);
}

TEST(ArrivalHold, IsSixtyMillisecondsAtMost) {
  Network network(3);
  network.run(10, [](std::size_t, double, Random& random) { return exponential(random, 100); });
  EXPECT_EQ(network.hold.now(), ArrivalHold::kMost);
  EXPECT_EQ(network.longest, 60 * kMs);
}

TEST(ArrivalHold, NoSensorAloneHoldsFrames) {
  Network network(12);
  network.run(20, [](std::size_t s, double, Random& random) {
    return s == 3 ? from_seconds(random.uniform(0, 0.2)) : exponential(random, 4);
  });
  EXPECT_EQ(network.longest, Duration::zero());
}

TEST(ArrivalHold, NoSensorAloneSaysForHowLong) {
  Network network(12);
  network.run(20, [](std::size_t s, double, Random& random) {
    return s == 3 ? from_seconds(random.uniform(0, 0.2)) : from_seconds(random.uniform(0, 0.024));
  });
  EXPECT_GT(network.hold.now(), 20 * kMs);
  EXPECT_LE(network.longest, 24 * kMs);
}

TEST(ArrivalHold, AClockThatStoodStillIsNoJitter) {
  Network network(12);
  network.run(5, [](std::size_t, double, Random& random) { return exponential(random, 4); });
  network.run(8, [](std::size_t, double, Random& random) { return 600 * kMs + exponential(random, 4); });
  EXPECT_EQ(network.longest, Duration::zero());
}

}  // namespace
}  // namespace mien::sensor::arrival_hold_test
