// Devices in trouble: each kind, and what becomes of ticks and truth.
#include "mien/virtual/imu/device_trouble.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "tests/lab/imu/impaired_session.h"

namespace mien::lab::device_trouble_test {
namespace {

using test::expect_sound;
using test::impaired;
using test::packets;
using test::seconds;
using test::session;
using ::testing::HasSubstr;

constexpr std::uint16_t kMentalis = 0;
constexpr std::uint16_t kEar = 2;  // The reference.

/// The truth's jaw against what the motion did at the true time of each evaluated tick, as the packets of the
/// chin's own sensor place it: the largest difference.
double truth_against(const virt::VirtualSession& of, const std::function<DeviceTime(DeviceTime)>& old_time) {
  double worst = 0;
  std::size_t next = 0;
  for (const take::TruthFrame& truth : of.truth) {
    if (!truth.evaluated) continue;
    const DeviceTime old = old_time(truth.time);
    while (next + 1 < session().truth.size() && session().truth[next + 1].time <= old) ++next;
    if (next + 1 >= session().truth.size()) break;
    const auto& a = session().truth[next];
    const auto& b = session().truth[next + 1];
    const double u = to_seconds(old - a.time) / to_seconds(b.time - a.time);
    const std::size_t jaw = face::shape("jawOpen");
    worst = std::max(worst, std::abs(truth.weights[jaw] - ((1 - u) * a.weights[jaw] + u * b.weights[jaw])));
  }
  return worst;
}

TEST(Troubles, ASilentSensorIsSilentThenAndOnlyThen) {
  const virt::VirtualSession quiet =
      impaired({}, {.silences = {{.sensor = kMentalis, .from_s = 5, .to_s = 7}}});
  expect_sound(quiet);
  for (const auto& [arrival, packet] : packets(quiet, kMentalis))
    EXPECT_TRUE(seconds(arrival) < 5 || seconds(arrival) >= 7) << seconds(arrival);
  EXPECT_NEAR(static_cast<double>(packets(session(), kMentalis).size() - packets(quiet, kMentalis).size()),
              120, 2);
  EXPECT_EQ(packets(quiet, kEar).size(), packets(session(), kEar).size());
}

TEST(Troubles, WhenAllAreSilentTheGridRunsOn) {
  const virt::VirtualSession quiet = impaired({}, {.silences = {{.sensor = {}, .from_s = 5, .to_s = 7}}});
  expect_sound(quiet);
  for (const take::LogEntry& entry : quiet.entries)
    EXPECT_TRUE(seconds(entry.arrival) < 5 || seconds(entry.arrival) >= 7);
  // Frames of the silence fire, at the latest with what comes after it.
  EXPECT_EQ(quiet.ticks.size(), session().ticks.size());
}

TEST(Troubles, AFrozenSensorSendsValidPacketsOfTheSameValues) {
  const virt::VirtualSession frozen =
      impaired({}, {.frozen = {{.sensor = kMentalis, .from_s = 5, .to_s = 9}}});
  expect_sound(frozen);
  const auto all = packets(frozen, kMentalis);
  const auto before = packets(session(), kMentalis);
  ASSERT_EQ(all.size(), before.size());
  const std::array<float, 9>* held = nullptr;
  std::size_t still = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto& [arrival, packet] = all[i];
    EXPECT_EQ(packet.time, before[i].second.time);
    EXPECT_EQ(packet.sequence, before[i].second.sequence);
    if (seconds(arrival) < 5 || seconds(arrival) >= 9) {
      EXPECT_EQ(packet, before[i].second);
      continue;
    }
    if (held == nullptr) held = &packet.values[0];
    for (std::size_t k = 0; k < packet.count; ++k) EXPECT_EQ(packet.values[k], *held);
    ++still;
  }
  EXPECT_NEAR(static_cast<double>(still), 240, 2);
}

TEST(Troubles, ARestartedNodeCountsFromNought) {
  const virt::VirtualSession again =
      impaired({}, {.restarts = {{.sensor = kMentalis, .at_s = 6, .boot_s = 1}}});
  expect_sound(again);
  bool restarted = false;
  DeviceTime last;
  for (const auto& [arrival, packet] : packets(again, kMentalis)) {
    EXPECT_TRUE(seconds(arrival) < 6 || seconds(arrival) >= 7);
    if (seconds(arrival) >= 7 && !restarted) {
      restarted = true;
      EXPECT_EQ(packet.time, DeviceTime());
      EXPECT_EQ(packet.sequence, 0U);
    } else if (restarted) {
      EXPECT_LT(packet.sequence, 60 * 30U);
      EXPECT_NEAR(to_seconds(packet.time.time_since_epoch()), seconds(arrival) - 7, 0.05);
    }
    last = packet.time;
  }
  EXPECT_TRUE(restarted);
}

TEST(Troubles, ARestartedReferenceLeavesTheTruthInPlace) {
  const virt::VirtualSession again = impaired({}, {.restarts = {{.sensor = kEar, .at_s = 15, .boot_s = 1}}});
  expect_sound(again);
  // The line goes on where it left off, as well as the first packet's arrival tells where that is.
  DeviceTime line_at_restart;
  for (const take::Tick& tick : again.ticks)
    if (seconds(tick.fired) < 16) line_at_restart = tick.frame;
  double best = 1;
  for (double shift_ms = -20; shift_ms <= 20; shift_ms += 0.25)
    best = std::min(best, truth_against(again, [&](DeviceTime time) {
                      return time <= line_at_restart ? time : time + from_seconds(1e-3 * shift_ms);
                    }));
  EXPECT_LT(best, 0.01);
  for (std::size_t i = 0; i < session().events.size(); ++i)
    EXPECT_EQ(again.events[i].begin, session().events[i].begin);  // All before it.
}

TEST(Troubles, AClockThatIsOffDriftsAndJumps) {
  const virt::VirtualSession off =
      impaired({}, {.clocks = {{.sensor = kMentalis, .drift_ppm = 50, .step_us = 500, .step_every_s = 4}}});
  expect_sound(off);
  const auto before = packets(session(), kMentalis);
  const auto after = packets(off, kMentalis);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double on_s = to_seconds(before[i].second.time - before[0].second.time);
    const double expected_us = 50 * on_s + 500 * std::floor(on_s / 4);
    EXPECT_NEAR(1e6 * to_seconds(after[i].second.time - before[i].second.time), expected_us, 1);
    EXPECT_EQ(after[i].second.values, before[i].second.values);
  }
}

TEST(Troubles, AReferenceThatIsOffCarriesItsTruthAlong) {
  const virt::VirtualSession off = impaired(
      {.lag_ms = 30}, {.clocks = {{.sensor = kEar, .drift_ppm = 50, .step_us = 500, .step_every_s = 2}}});
  expect_sound(off);
  const DeviceTime first = packets(session(), kEar)[0].second.time;
  // The other way round, to first order.
  const auto old_time = [&](DeviceTime time) {
    const double on_s = to_seconds(time - first);
    return time - from_seconds(1e-6 * (50 * on_s + 500 * std::floor(on_s / 2)));
  };
  // The jaw opens and shuts in two thirds of a second: a millisecond is half a hundredth of it.
  EXPECT_LT(truth_against(off, old_time), 0.004);
  EXPECT_GT(truth_against(off, [](DeviceTime time) { return time; }), 0.02);
}

TEST(Troubles, WithoutItsReferenceTheSessionStandsOnTheHostsTime) {
  const virt::VirtualSession without =
      impaired({}, {.silences = {{.sensor = kEar, .from_s = -10, .to_s = 1000}}});
  expect_sound(without);
  ASSERT_FALSE(without.ticks.empty());
  std::size_t evaluated = 0;
  for (const take::TruthFrame& truth : without.truth) evaluated += truth.evaluated ? 1 : 0;
  EXPECT_NEAR(static_cast<double>(evaluated), 1200, 5);
  // The host's time is small; the reference's clock began somewhere in its first minute.
  EXPECT_NEAR(seconds(HostTime(without.motion_start.time_since_epoch())), 12.5, 0.05);
}

TEST(Troubles, TwoBoardsOfOneIdAreHeardAsOne) {
  const virt::VirtualSession shared = impaired({}, {.shared_ids = {{.sensor = kMentalis, .as = 1}}});
  expect_sound(shared);
  EXPECT_TRUE(packets(shared, kMentalis).empty());
  EXPECT_EQ(packets(shared, 1).size(), packets(session(), kMentalis).size() + packets(session(), 1).size());
}

TEST(Troubles, SeveralAtOnceActInTurn) {
  const virt::VirtualSession all =
      impaired({.loss = 0.05, .jitter_ms = 10}, {.clocks = {{.sensor = 1, .drift_ppm = -50}},
                                                 .frozen = {{.sensor = kMentalis, .from_s = 3, .to_s = 5}},
                                                 .restarts = {{.sensor = kMentalis, .at_s = 8}},
                                                 .silences = {{.sensor = kMentalis, .from_s = 12, .to_s = 13},
                                                              {.sensor = {}, .from_s = 15, .to_s = 16}}});
  expect_sound(all);
  EXPECT_LT(all.entries.size(), session().entries.size());
}

TEST(Troubles, EachWrongOneIsRefused) {
  const auto refused = [](const virt::DeviceTroubles& troubles, const char* words) {
    const auto out = impair(session(), virt::test::three_sensors(), {}, Random(1), troubles);
    ASSERT_FALSE(out) << words;
    EXPECT_EQ(out.error().code, ErrorCode::out_of_range);
    EXPECT_THAT(out.error().message(), HasSubstr(words));
  };
  refused({.clocks = {{.drift_ppm = 5000}}}, "drift");
  refused({.clocks = {{.drift_ppm = std::nan("")}}}, "drift");
  refused({.clocks = {{.step_us = 1e6}}}, "step");
  refused({.clocks = {{.step_every_s = 0}}}, "pause");
  refused({.frozen = {{.from_s = 3, .to_s = 2}}}, "stretch");
  refused({.restarts = {{.boot_s = -1}}}, "stretch");
  refused({.silences = {{.from_s = 3, .to_s = std::nan("")}}}, "stretch");
}

TEST(Troubles, RefuseWhatIsNoPacketOfSamples) {
  const auto out = virt::trouble_devices({{{}, kMentalis, std::vector<std::byte>(40)}},
                                         {.silences = {{.sensor = kMentalis, .from_s = 0, .to_s = 1}}});
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().code, ErrorCode::bad_usage);
}

}  // namespace
}  // namespace mien::lab::device_trouble_test
