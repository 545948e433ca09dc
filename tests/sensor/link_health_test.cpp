#include "mien/sensor/link_health.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "mien/core/random.h"

namespace mien::sensor::link_health_test {
namespace {

constexpr Duration kMs = std::chrono::milliseconds(1);
constexpr double kRate = 240;

/// A node at 240 Hz with packets of four, on a true time line of its own: what it would send, and when.
struct Node {
  double t = 0;  // True time of the next packet's first sample, s.
  double clock_s = 12.5;
  double rate = 1 + 20e-6;
  std::uint32_t sequence = 0;
  SampleKind kind = SampleKind::imu_raw;
  std::uint8_t count = 6;
  bool estimated = false;
  bool still = false;        // The values do not change.
  bool gyro_still = false;   // Those of the gyroscope do not.
  Duration delay = 2 * kMs;  // From a packet's last sample to its arrival.
  Random random{11};
  std::array<float, kMaxSampleValues> held{};

  [[nodiscard]] HostTime arrival() const { return HostTime(from_seconds(t + 3 / kRate) + delay); }
  std::array<Sample, 4> packet() {
    std::array<Sample, 4> samples;
    for (int i = 0; i < 4; ++i) {
      Sample& s = samples[static_cast<std::size_t>(i)];
      s.kind = kind;
      s.sequence = sequence;
      s.time = DeviceTime(from_seconds(clock_s + rate * (t + i / kRate)));
      s.time_estimated = estimated;
      s.count = count;
      for (std::size_t v = 0; v < count; ++v)
        if (!still && !(gyro_still && v < 3)) held[v] = static_cast<float>(random.normal(0, 0.01));
      s.values = held;
    }
    ++sequence;
    t += 4 / kRate;
    return samples;
  }
  void skip() { packet(); }
};

void send(LinkHealth& link, Node& node, bool saturated = false) {
  const HostTime arrival = node.arrival();
  for (const Sample& s : node.packet()) link.add(arrival, s, saturated);
}
/// Plays `seconds` and returns the time just after the last arrival.
HostTime play(LinkHealth& link, Node& node, double seconds) {
  const double end = node.t + seconds;
  HostTime arrival;
  while (node.t < end) {
    arrival = node.arrival();
    send(link, node);
  }
  return arrival + kMs;
}
LinkState state(const LinkHealth& link, HostTime now) {
  return link.report(now, {}).state;
}

TEST(LinkHealth, HasANameForEveryState) {
  EXPECT_EQ(link_state_name(LinkState::unbound), "unbound");
  EXPECT_EQ(link_state_name(LinkState::silent), "silent");
  EXPECT_EQ(link_state_name(LinkState::good), "good");
  EXPECT_EQ(link_state_name(LinkState::lossy), "lossy");
  EXPECT_EQ(link_state_name(LinkState::late), "late");
  EXPECT_EQ(link_state_name(LinkState::lost), "lost");
  EXPECT_EQ(link_state_name(LinkState::frozen), "frozen");
  EXPECT_EQ(link_state_name(LinkState::saturated), "saturated");
  EXPECT_EQ(link_state_name(LinkState::unchanged), "unchanged");
  EXPECT_EQ(link_state_name(LinkState::restarted), "restarted");
  EXPECT_EQ(link_state_name(LinkState::duplicate), "duplicate");
  EXPECT_EQ(link_state_name(LinkState::no_face), "no_face");
}

TEST(LinkHealth, IsSilentUntilASampleComes) {
  LinkHealth link;
  LinkReport report = link.report(HostTime(5 * kMs), {});
  EXPECT_EQ(report.state, LinkState::silent);
  EXPECT_FALSE(report.age);
  EXPECT_EQ(report.rate_hz, 0);
  EXPECT_FALSE(report.battery_percent);
  link.add_alive(HostTime(6 * kMs));
  link.add_malformed();
  report = link.report(HostTime(7 * kMs), {});
  EXPECT_EQ(report.state, LinkState::silent);
  EXPECT_EQ(report.malformed, 1u);
}

TEST(LinkHealth, IsGoodWhenAllComes) {
  LinkHealth link;
  Node node;
  const HostTime now = play(link, node, 10);
  const LinkClock clock{.offset = 3 * kMs, .drift_ppm = -20, .uncertainty = kMs};
  link.set_battery(87);
  const LinkReport report = link.report(now, clock);
  EXPECT_EQ(report.state, LinkState::good);
  EXPECT_EQ(report.age, kMs);
  EXPECT_NEAR(report.rate_hz, kRate, 2);
  EXPECT_EQ(report.lost + report.late + report.doubled + report.reordered + report.restarts, 0u);
  EXPECT_EQ(report.loss, 0);
  EXPECT_EQ(report.battery_percent, 87);
  EXPECT_FALSE(report.estimated);
  EXPECT_EQ(report.clock, clock);
  link.set_battery(255);
  EXPECT_EQ(link.report(now, {}).battery_percent, 100);
}

TEST(LinkHealth, GoesAroundTheWrapOfTheSequence) {
  LinkHealth link;
  Node node;
  node.sequence = 0xffffffffu - 100;
  for (int i = 0; i < 300; ++i) {
    if (i % 50 == 25)
      node.skip();
    else
      send(link, node);
  }
  const LinkReport report = link.report(node.arrival(), {});
  EXPECT_EQ(report.state, LinkState::good);
  EXPECT_EQ(report.lost, 6u);
  EXPECT_NEAR(report.loss, 0.02, 0.005);
  EXPECT_EQ(report.restarts, 0u);
}

TEST(LinkHealth, IsGoodUnderTheDefaultRadio) {
  LinkHealth link;
  Node node;
  Random random(5);
  for (int i = 0; i < 60 * 120; ++i) {
    node.delay = from_seconds(0.001 + random.exponential(0.003));
    if (random.chance(0.005))
      node.skip();
    else
      send(link, node);
    if (i > 60) {
      ASSERT_EQ(state(link, HostTime(from_seconds(node.t) + 20 * kMs)), LinkState::good) << i;
    }
  }
}

TEST(LinkHealth, IsLossyAboveFivePerCent) {
  for (const double share : {0.02, 0.15}) {
    LinkHealth link;
    Node node;
    Random random(2);
    for (int i = 0; i < 600; ++i)
      if (random.chance(share) && i < 599)
        node.skip();
      else
        send(link, node);
    const LinkReport report = link.report(node.arrival() - 10 * kMs, {});
    EXPECT_EQ(report.state, share < 0.05 ? LinkState::good : LinkState::lossy);
    EXPECT_NEAR(report.loss, share, 0.03);
    EXPECT_NEAR(static_cast<double>(report.lost), share * 600, 20);
    // And it is forgiven when it is over.
    EXPECT_EQ(state(link, play(link, node, 6)), LinkState::good);
  }
}

TEST(LinkHealth, TellsReorderedFromLostAndDoubled) {
  LinkHealth link;
  Node node;
  play(link, node, 2);
  const auto early = node.packet();
  const HostTime arrival = node.arrival();
  const auto later = node.packet();
  for (const Sample& s : later) link.add(arrival, s, false);
  EXPECT_EQ(link.report(arrival, {}).lost, 1u);
  for (const Sample& s : early) link.add(arrival + kMs, s, false);
  LinkReport report = link.report(arrival + kMs, {});
  EXPECT_EQ(report.lost, 0u);
  EXPECT_EQ(report.loss, 0);
  EXPECT_EQ(report.reordered, 1u);
  EXPECT_EQ(report.doubled, 0u);
  for (const Sample& s : early) link.add(arrival + 2 * kMs, s, false);
  for (const Sample& s : later) link.add(arrival + 2 * kMs, s, false);  // Even within one instant.
  for (const Sample& s : later) link.add(arrival + 2 * kMs, s, false);
  report = link.report(arrival + 2 * kMs, {});
  EXPECT_EQ(report.doubled, 3u);
  EXPECT_EQ(report.reordered, 1u);
  EXPECT_EQ(report.state, LinkState::good);
  EXPECT_NEAR(link.report(play(link, node, 5), {}).rate_hz, kRate, 2);
}

TEST(LinkHealth, IsLostAfterATenthOfASecondAndNeverGoodWhenStale) {
  LinkHealth link;
  Node node;
  const HostTime last = play(link, node, 3) - kMs;
  EXPECT_EQ(state(link, last + 100 * kMs), LinkState::good);
  for (int ms = 101; ms < 60'000; ms += 37) ASSERT_EQ(state(link, last + ms * kMs), LinkState::lost);
  LinkReport report = link.report(last + 400 * kMs, {});
  EXPECT_EQ(report.age, 400 * kMs);
  EXPECT_GT(report.loss, 0.05);
  report = link.report(last + 10'000 * kMs, {});
  EXPECT_EQ(report.loss, 1);
  EXPECT_EQ(report.rate_hz, 0);
  // Back: what was missed shows as loss, and is forgiven.
  for (int i = 0; i < 60; ++i) node.skip();
  EXPECT_EQ(state(link, play(link, node, 0.1)), LinkState::lossy);
  EXPECT_EQ(link.report(last, {}).lost, 60u);
  EXPECT_EQ(state(link, play(link, node, 6)), LinkState::good);
  EXPECT_EQ(link.report(last, {}).restarts, 0u);
}

TEST(LinkHealth, ReportsNoNegativeAge) {
  LinkHealth link;
  Node node;
  const HostTime last = play(link, node, 1) - kMs;
  EXPECT_EQ(link.report(last - 500 * kMs, {}).age, Duration{});
}

TEST(LinkHealth, IsLateWhenPacketsMissTheirFrames) {
  LinkHealth link;
  Node node;
  Random random(3);
  play(link, node, 10);
  for (int i = 0; i < 300; ++i) {
    node.delay = 2 * kMs + (random.chance(0.2) ? 60 * kMs : 0 * kMs);
    send(link, node);
  }
  node.delay = 2 * kMs;
  const HostTime now = play(link, node, 0.1);
  const LinkReport report = link.report(now, {});
  EXPECT_EQ(report.state, LinkState::late);
  EXPECT_NEAR(static_cast<double>(report.late), 60, 20);
  EXPECT_EQ(state(link, play(link, node, 6)), LinkState::good);
}

TEST(LinkHealth, IsLateWhenPacketsComeInBursts) {
  LinkHealth link;
  Node node;
  play(link, node, 3);
  HostTime now;
  for (int burst = 0; burst < 60; ++burst) {
    // Five packets at once, as the last is there.
    now = node.arrival() + from_seconds(4 * 4 / kRate);
    for (int i = 0; i < 5; ++i)
      for (const Sample& s : node.packet()) link.add(now, s, false);
  }
  EXPECT_EQ(state(link, now + kMs), LinkState::late);
  EXPECT_EQ(link.report(now, {}).lost, 0u);
}

TEST(LinkHealth, DoesNotTakeDriftForLateness) {
  for (const double ppm : {-80.0, 80.0}) {
    LinkHealth link;
    Node node;
    node.rate = 1 + 1e-6 * ppm;
    const HostTime now = play(link, node, 1200);
    EXPECT_EQ(link.report(now, {}).late, 0u);
    EXPECT_EQ(state(link, now), LinkState::good);
  }
}

TEST(LinkHealth, SeesAFrozenSensor) {
  for (const SampleKind kind : {SampleKind::imu_raw, SampleKind::imu_fused, SampleKind::imu_head_relative}) {
    LinkHealth link;
    Node node;
    node.kind = kind;
    node.count = kind == SampleKind::imu_raw ? 6 : kind == SampleKind::imu_fused ? 7 : 3;
    EXPECT_EQ(state(link, play(link, node, 2)), LinkState::good);
    node.still = true;
    EXPECT_EQ(state(link, play(link, node, 0.4)), LinkState::good);
    EXPECT_EQ(state(link, play(link, node, 0.2)), LinkState::frozen);
    EXPECT_EQ(state(link, play(link, node, 20)), LinkState::frozen);
    node.still = false;
    EXPECT_EQ(state(link, play(link, node, 0.05)), LinkState::good);
  }
}

TEST(LinkHealth, AQuietRoomIsNotFrozen) {
  LinkHealth link;
  Node node;
  node.kind = SampleKind::sound;
  node.count = 2;
  node.still = true;
  EXPECT_EQ(state(link, play(link, node, 5)), LinkState::good);
}

TEST(LinkHealth, SeesOneFrozenChipOfTwo) {
  LinkHealth link;
  Node node;
  play(link, node, 2);
  node.gyro_still = true;
  EXPECT_EQ(state(link, play(link, node, 0.6)), LinkState::frozen);
}

TEST(LinkHealth, AGapBetweenEqualValuesIsNoFreeze) {
  LinkHealth link;
  Node node;
  play(link, node, 2);
  node.still = true;
  send(link, node);
  for (int i = 0; i < 40; ++i) node.skip();
  EXPECT_NE(state(link, play(link, node, 0.4)), LinkState::frozen);
  EXPECT_EQ(state(link, play(link, node, 0.2)), LinkState::frozen);
}

TEST(LinkHealth, ShowsSaturationForHalfASecond) {
  LinkHealth link;
  Node node;
  play(link, node, 2);
  send(link, node, true);
  EXPECT_EQ(state(link, play(link, node, 0.3)), LinkState::saturated);
  EXPECT_EQ(state(link, play(link, node, 0.4)), LinkState::good);
}

TEST(LinkHealth, ShowsARestartForAFewSeconds) {
  LinkHealth link;
  Node node;
  play(link, node, 5);
  node.t += 1.5;  // It boots.
  node.clock_s = -node.t;
  node.sequence = 0;
  EXPECT_EQ(state(link, play(link, node, 0.5)), LinkState::restarted);
  EXPECT_EQ(state(link, play(link, node, 2)), LinkState::restarted);
  const HostTime now = play(link, node, 2);
  EXPECT_EQ(state(link, now), LinkState::good);
  const LinkReport report = link.report(now, {});
  EXPECT_EQ(report.restarts, 1u);
  EXPECT_EQ(report.lost, 0u);
}

TEST(LinkHealth, SeesARestartOfTheSequenceAlone) {
  LinkHealth link;
  Node node;
  play(link, node, 5);
  node.sequence = 0;
  EXPECT_EQ(state(link, play(link, node, 0.5)), LinkState::restarted);
  EXPECT_EQ(state(link, play(link, node, 4)), LinkState::good);
}

TEST(LinkHealth, AStragglerFromBeforeARestartIsNoSecondDevice) {
  LinkHealth link;
  Node node;
  play(link, node, 5);
  Node old = node;
  const auto straggler = old.packet();
  node.t += 0.5;
  node.clock_s = -node.t;
  node.sequence = 0;
  const HostTime now = play(link, node, 0.2);
  for (const Sample& s : straggler) link.add(now, s, false);
  EXPECT_EQ(state(link, play(link, node, 0.5)), LinkState::restarted);
  EXPECT_EQ(state(link, play(link, node, 4)), LinkState::good);
}

/// Plays two nodes with one id side by side.
HostTime play_two(LinkHealth& link, Node& a, Node& b, double seconds) {
  const double end = a.t + seconds;
  HostTime now;
  while (a.t < end) {
    Node& next = a.arrival() <= b.arrival() ? a : b;
    now = next.arrival();
    send(link, next);
  }
  return now;
}

TEST(LinkHealth, SeesTwoDevicesWithOneId) {
  // Far apart, a little apart, and switched on at the same moment.
  for (const double apart_s : {-1000.0, -40.0, 3.0, 0.7, 0.02, 0.0}) {
    LinkHealth link;
    Node a;
    a.sequence = 70'000;
    Node b;
    b.t = 0.005;
    b.clock_s = a.clock_s + apart_s;
    b.sequence = a.sequence + static_cast<std::uint32_t>(static_cast<std::int64_t>(apart_s * kRate / 4));
    b.random = Random(12);
    HostTime now = play_two(link, a, b, 1);
    EXPECT_EQ(state(link, now), LinkState::duplicate) << apart_s;
    for (int i = 0; i < 20; ++i)
      ASSERT_EQ(state(link, play_two(link, a, b, 0.5)), LinkState::duplicate) << apart_s;
    EXPECT_LT(link.report(a.arrival(), {}).lost, 3u) << apart_s;
    // One of them is switched off.
    EXPECT_EQ(state(link, play(link, a, 9)), LinkState::good) << apart_s;
  }
}

/// A SlimeVR node: one sample a packet, times are estimated, its numbers count packets of every kind.
struct SlimeNode {
  std::int64_t index = 0;
  std::uint32_t sequence = 900;
  float value = 0.5f;
  HostTime send(LinkHealth& link) {
    const HostTime arrival(10 * kMs * index);
    Sample s;
    s.kind = SampleKind::imu_fused;
    s.sequence = sequence;
    s.time = DeviceTime(arrival.time_since_epoch());
    s.time_estimated = true;
    s.count = 7;
    value = -value * 0.999f;
    s.values.fill(value);
    link.add(arrival, s, false);
    ++index;
    sequence += 3;
    return arrival;
  }
};

TEST(LinkHealth, GapsInNumbersOfPacketsOfEveryKindAreNoLoss) {
  LinkHealth link;
  SlimeNode node;
  HostTime now;
  for (int i = 0; i < 1000; ++i) now = node.send(link);
  const LinkReport report = link.report(now, {});
  EXPECT_EQ(report.state, LinkState::good);
  EXPECT_TRUE(report.estimated);
  EXPECT_EQ(report.lost, 0u);
  EXPECT_EQ(report.loss, 0);
  EXPECT_NEAR(report.rate_hz, 100, 1);
}

TEST(LinkHealth, AnEstimatedSensorIsUnchangedBeforeItIsLost) {
  LinkHealth link;
  SlimeNode node;
  HostTime now;
  for (int i = 0; i < 200; ++i) now = node.send(link);
  EXPECT_EQ(state(link, now + 90 * kMs), LinkState::good);
  EXPECT_EQ(state(link, now + 110 * kMs), LinkState::unchanged);
  EXPECT_EQ(state(link, now + 1000 * kMs), LinkState::unchanged);
  EXPECT_EQ(state(link, now + 1001 * kMs), LinkState::lost);
  link.add_alive(now + 900 * kMs);
  EXPECT_EQ(state(link, now + 1001 * kMs), LinkState::lost);
}

TEST(LinkHealth, AnAnsweringBoardMayBeTrustedLonger) {
  LinkHealth link({.unchanged_for = std::chrono::seconds(10)});
  SlimeNode node;
  HostTime now;
  for (int i = 0; i < 200; ++i) now = node.send(link);
  EXPECT_EQ(state(link, now + 1100 * kMs), LinkState::lost);  // It does not answer.
  for (int i = 1; i < 12; ++i) {
    link.add_alive(now + i * 1000 * kMs);
    EXPECT_EQ(state(link, now + i * 1000 * kMs + kMs), i < 10 ? LinkState::unchanged : LinkState::lost);
  }
}

TEST(LinkHealth, SeesAnEstimatedBoardRestart) {
  LinkHealth link;
  SlimeNode node;
  node.sequence = 90'000;
  HostTime now;
  for (int i = 0; i < 200; ++i) now = node.send(link);
  node.sequence = 1;
  for (int i = 0; i < 20; ++i) now = node.send(link);
  EXPECT_EQ(state(link, now), LinkState::restarted);
  for (int i = 0; i < 320; ++i) now = node.send(link);
  EXPECT_EQ(state(link, now), LinkState::good);
}

TEST(LinkHealth, SurvivesAnything) {
  LinkHealth link;
  Random random(8);
  for (int i = 0; i < 200'000; ++i) {
    Sample s;
    s.kind = static_cast<SampleKind>(1 + random.below(3));
    s.sequence = static_cast<std::uint32_t>(random.chance(0.5) ? random.bits() : random.below(50));
    s.time = DeviceTime(Duration(random.chance(0.5)
                                     ? static_cast<std::int64_t>(random.below(100'000'000'000'000'000))
                                     : static_cast<std::int64_t>(random.below(1'000'000'000))));
    s.time_estimated = random.chance(0.2);
    s.count = static_cast<std::uint8_t>(random.below(kMaxSampleValues + 1));
    const HostTime arrival(Duration(static_cast<std::int64_t>(random.below(1'000'000'000'000))));
    if (random.chance(0.1)) s.values.fill(std::nanf(""));
    link.add(arrival, s, random.chance(0.1));
    if (i % 100 != 0) continue;
    const LinkReport report = link.report(arrival + 50 * kMs, {});
    ASSERT_GE(report.loss, 0);
    ASSERT_LE(report.loss, 1);
    ASSERT_GE(report.rate_hz, 0);
    ASSERT_GE(*report.age, Duration{});
  }
}

TEST(LinkHealth, AskingChangesNothing) {
  LinkHealth asked;
  LinkHealth not_asked;
  Node a;
  Node b;
  for (int i = 0; i < 500; ++i) {
    if (i % 30 == 7) {
      a.skip();
      b.skip();
      continue;
    }
    send(asked, a);
    send(not_asked, b);
    (void)asked.report(a.arrival(), {});
  }
  const LinkReport x = asked.report(a.arrival(), {});
  const LinkReport y = not_asked.report(b.arrival(), {});
  EXPECT_EQ(x.state, y.state);
  EXPECT_EQ(x.lost, y.lost);
  EXPECT_EQ(x.loss, y.loss);
  EXPECT_EQ(x.rate_hz, y.rate_hz);
}

TEST(LinkHealth, ALivingBoardSaysNothingOfItsSensor) {
  LinkHealth link;
  Node node;
  HostTime now = play(link, node, 1);
  for (int i = 0; i < 20; ++i) link.add_alive(now += 50 * kMs);
  EXPECT_EQ(state(link, now), LinkState::lost);
}

}  // namespace
}  // namespace mien::sensor::link_health_test
