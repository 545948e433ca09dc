// A session heard through a worse network, from devices in trouble.
#include "mien/virtual/impair.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "mien/imu/packet.h"
#include "mien/imu/pipeline.h"
#include "mien/take/session_log.h"
#include "mien/virtual/device_packet.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt {
namespace {

using ::testing::HasSubstr;

constexpr std::uint16_t kMentalis = 0;
constexpr std::uint16_t kEar = 2;  // The reference.

/// Twenty seconds and a prologue.
const VirtualSession& session() {
  static const VirtualSession played =
      play_devices(with_prologue(test::talking(1201), PrologueKind::brief, Random(3)), test::three_sites(),
                   test::three_sensors(), test::mild_faults(), Random(11))
          .value();
  return played;
}

VirtualSession impaired(const NetworkSettings& settings, const DeviceTroubles& troubles = {},
                        std::uint64_t seed = 5) {
  return impair(session(), test::three_sensors(), settings, Random(seed), troubles).value();
}

/// The packets of one device id, in order of arrival, with when.
std::vector<std::pair<HostTime, imu::Packet>> packets(const VirtualSession& of, std::uint16_t sensor) {
  std::vector<std::pair<HostTime, imu::Packet>> out;
  for (const take::LogEntry& entry : of.entries) {
    const auto packet = imu::parse_packet(entry.bytes);
    if (packet && packet->device == virtual_device(sensor)) out.emplace_back(entry.arrival, *packet);
  }
  return out;
}

double seconds(HostTime time) {
  return to_seconds(time.time_since_epoch());
}

/// What holds of every session: entries by arrival, samples of their entries, ticks on the grid, a truth
/// each.
void expect_sound(const VirtualSession& of) {
  for (std::size_t i = 0; i < of.entries.size(); ++i) {
    ASSERT_EQ(of.entries[i].id, static_cast<std::int64_t>(i) + 1);
    if (i > 0) {
      ASSERT_LE(of.entries[i - 1].arrival, of.entries[i].arrival);
    }
  }
  for (std::size_t i = 0; i < of.samples.size(); ++i) {
    ASSERT_GE(of.samples[i].entry, i == 0 ? 1 : of.samples[i - 1].entry);
    ASSERT_LE(of.samples[i].entry, static_cast<std::int64_t>(of.entries.size()));
  }
  ASSERT_EQ(of.truth.size(), of.ticks.size());
  for (std::size_t i = 0; i < of.ticks.size(); ++i) {
    EXPECT_EQ(of.ticks[i].frame, DeviceTime(frame_offset(of.ticks[i].index)));
    EXPECT_EQ(of.truth[i].time, of.ticks[i].frame);
    if (i > 0) {
      ASSERT_EQ(of.ticks[i].index, of.ticks[i - 1].index + 1);
      ASSERT_GE(of.ticks[i].fired, of.ticks[i - 1].fired);
      ASSERT_GE(of.ticks[i].after_entry, of.ticks[i - 1].after_entry);
    }
  }
}

/// The truth's jaw against what the motion did at the true time of each evaluated tick, as the packets of the
/// chin's own sensor place it: the largest difference.
double truth_against(const VirtualSession& of, const std::function<DeviceTime(DeviceTime)>& old_time) {
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

TEST(Impair, APerfectNetworkGivesTheSessionBack) {
  const VirtualSession same = impaired({});
  expect_sound(same);
  ASSERT_EQ(same.entries.size(), session().entries.size());
  for (std::size_t i = 0; i < same.entries.size(); ++i) {
    EXPECT_EQ(same.entries[i].arrival, session().entries[i].arrival);
    EXPECT_EQ(same.entries[i].bytes, session().entries[i].bytes);
  }
  ASSERT_EQ(same.samples.size(), session().samples.size());
  ASSERT_EQ(same.ticks.size(), session().ticks.size());
  for (std::size_t i = 0; i < same.ticks.size(); ++i) {
    EXPECT_EQ(same.ticks[i].fired, session().ticks[i].fired);
    EXPECT_EQ(same.ticks[i].after_entry, session().ticks[i].after_entry);
    EXPECT_EQ(same.truth[i].weights, session().truth[i].weights);
    EXPECT_EQ(same.truth[i].evaluated, session().truth[i].evaluated);
  }
  EXPECT_EQ(same.motion_start, session().motion_start);
  ASSERT_EQ(same.events.size(), session().events.size());
  for (std::size_t i = 0; i < same.events.size(); ++i) {
    EXPECT_EQ(same.events[i].kind, session().events[i].kind);
    EXPECT_EQ(same.events[i].begin, session().events[i].begin);
    EXPECT_EQ(same.events[i].end, session().events[i].end);
  }
}

TEST(Impair, AWorseNetworkLeavesTheTruthWhereItStood) {
  const VirtualSession worse = impaired({.loss = 0.1,
                                         .burst_share = 0.05,
                                         .lag_ms = 20,
                                         .jitter_ms = 30,
                                         .duplicated = 0.02,
                                         .corrupted = 0.02,
                                         .truncated = 0.02});
  expect_sound(worse);
  EXPECT_LT(worse.samples.size(), 0.9 * static_cast<double>(session().samples.size()));
  EXPECT_GT(worse.samples.size(), 0.75 * static_cast<double>(session().samples.size()));
  // Of the same frames, bit for bit.
  std::size_t evaluated = 0;
  for (const take::TruthFrame& truth : worse.truth) {
    const auto old = std::ranges::lower_bound(session().truth, truth.time, {}, &take::TruthFrame::time);
    if (old == session().truth.end() || old->time != truth.time) continue;
    EXPECT_EQ(truth.weights, old->weights);
    EXPECT_EQ(truth.evaluated, old->evaluated);
    evaluated += truth.evaluated ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(evaluated), 1200, 10);
  EXPECT_EQ(worse.motion_start, session().motion_start);
}

TEST(Impair, TheSeedDecidesEveryByte) {
  const NetworkSettings settings{.loss = 0.1, .jitter_ms = 20, .corrupted = 0.05};
  const VirtualSession one = impaired(settings, {}, 8);
  const VirtualSession same = impaired(settings, {}, 8);
  ASSERT_EQ(one.entries.size(), same.entries.size());
  for (std::size_t i = 0; i < one.entries.size(); ++i) {
    ASSERT_EQ(one.entries[i].bytes, same.entries[i].bytes);
    ASSERT_EQ(one.entries[i].arrival, same.entries[i].arrival);
  }
  ASSERT_EQ(one.ticks.size(), same.ticks.size());
  for (std::size_t i = 0; i < one.ticks.size(); ++i) ASSERT_EQ(one.ticks[i].fired, same.ticks[i].fired);
  EXPECT_NE(impaired(settings, {}, 9).entries.size(), one.entries.size());
}

TEST(Impair, SamplesAreThoseOfThePacketsThatParse) {
  const VirtualSession worse = impaired({.corrupted = 0.1, .truncated = 0.1});
  EXPECT_EQ(worse.entries.size(), session().entries.size());
  std::size_t whole = 0;
  for (const take::LogEntry& entry : worse.entries) whole += imu::parse_packet(entry.bytes) ? 1 : 0;
  EXPECT_NEAR(static_cast<double>(whole), 0.81 * static_cast<double>(worse.entries.size()), 120);
  EXPECT_EQ(worse.samples.size(), 4 * whole);
}

TEST(Troubles, ASilentSensorIsSilentThenAndOnlyThen) {
  const VirtualSession quiet = impaired({}, {.silences = {{.sensor = kMentalis, .from_s = 5, .to_s = 7}}});
  expect_sound(quiet);
  for (const auto& [arrival, packet] : packets(quiet, kMentalis))
    EXPECT_TRUE(seconds(arrival) < 5 || seconds(arrival) >= 7) << seconds(arrival);
  EXPECT_NEAR(static_cast<double>(packets(session(), kMentalis).size() - packets(quiet, kMentalis).size()),
              120, 2);
  EXPECT_EQ(packets(quiet, kEar).size(), packets(session(), kEar).size());
}

TEST(Troubles, WhenAllAreSilentTheGridRunsOn) {
  const VirtualSession quiet = impaired({}, {.silences = {{.sensor = {}, .from_s = 5, .to_s = 7}}});
  expect_sound(quiet);
  for (const take::LogEntry& entry : quiet.entries)
    EXPECT_TRUE(seconds(entry.arrival) < 5 || seconds(entry.arrival) >= 7);
  // Frames of the silence fire, at the latest with what comes after it.
  EXPECT_EQ(quiet.ticks.size(), session().ticks.size());
}

TEST(Troubles, AFrozenSensorSendsValidPacketsOfTheSameValues) {
  const VirtualSession frozen = impaired({}, {.frozen = {{.sensor = kMentalis, .from_s = 5, .to_s = 9}}});
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
  const VirtualSession again = impaired({}, {.restarts = {{.sensor = kMentalis, .at_s = 6, .boot_s = 1}}});
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
  const VirtualSession again = impaired({}, {.restarts = {{.sensor = kEar, .at_s = 15, .boot_s = 1}}});
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
  const VirtualSession off =
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
  const VirtualSession off = impaired(
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
  const VirtualSession without = impaired({}, {.silences = {{.sensor = kEar, .from_s = -10, .to_s = 1000}}});
  expect_sound(without);
  ASSERT_FALSE(without.ticks.empty());
  std::size_t evaluated = 0;
  for (const take::TruthFrame& truth : without.truth) evaluated += truth.evaluated ? 1 : 0;
  EXPECT_NEAR(static_cast<double>(evaluated), 1200, 5);
  // The host's time is small; the reference's clock began somewhere in its first minute.
  EXPECT_NEAR(seconds(HostTime(without.motion_start.time_since_epoch())), 12.5, 0.05);
}

TEST(Troubles, TwoBoardsOfOneIdAreHeardAsOne) {
  const VirtualSession shared = impaired({}, {.shared_ids = {{.sensor = kMentalis, .as = 1}}});
  expect_sound(shared);
  EXPECT_TRUE(packets(shared, kMentalis).empty());
  EXPECT_EQ(packets(shared, 1).size(), packets(session(), kMentalis).size() + packets(session(), 1).size());
}

TEST(Troubles, SeveralAtOnceActInTurn) {
  const VirtualSession all =
      impaired({.loss = 0.05, .jitter_ms = 10}, {.clocks = {{.sensor = 1, .drift_ppm = -50}},
                                                 .frozen = {{.sensor = kMentalis, .from_s = 3, .to_s = 5}},
                                                 .restarts = {{.sensor = kMentalis, .at_s = 8}},
                                                 .silences = {{.sensor = kMentalis, .from_s = 12, .to_s = 13},
                                                              {.sensor = {}, .from_s = 15, .to_s = 16}}});
  expect_sound(all);
  EXPECT_LT(all.entries.size(), session().entries.size());
}

TEST(Troubles, EachWrongOneIsRefused) {
  const auto refused = [](const DeviceTroubles& troubles, const char* words) {
    const auto out = impair(session(), test::three_sensors(), {}, Random(1), troubles);
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

TEST(Impair, RefusesASessionWithoutTruth) {
  const auto out = impair(VirtualSession{}, test::three_sensors(), {}, Random(1));
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().code, ErrorCode::bad_usage);
}

TEST(Impair, ThePipelineStillFindsTheSkinThroughABadNetwork) {
  const VirtualSession worse = impaired({.loss = 0.1, .jitter_ms = 10});
  imu::Pipeline pipeline(test::three_sensors());
  for (const take::Event& event : worse.events)
    if (const auto phase = imu::phase_of(event.kind)) pipeline.mark(*phase, event.begin, event.end);
  const auto sites = test::three_sites();
  model::FeatureFrame frame;
  std::size_t tick = 0;
  double square = 0;
  double count = 0;
  for (const auto& step : take::replay_order(worse.samples, worse.ticks)) {
    if (step.item != nullptr) pipeline.add(step.item->arrival, step.item->sample);
    if (step.tick == nullptr) continue;
    pipeline.tick(step.tick->frame, frame);
    const take::TruthFrame& truth = worse.truth[tick++];
    if (!truth.evaluated || !frame.sensors[0].has_rotation) continue;
    const auto& q = frame.sensors[0].rotation;
    const double angle = sites[0].rotation(truth.weights).angularDistance(Quat(q[0], q[1], q[2], q[3]));
    square += angle * angle;
    ++count;
  }
  EXPECT_GT(count, 1000);
  RecordProperty("rms_deg", std::to_string(std::sqrt(square / count) * 57.29578));
  EXPECT_LT(std::sqrt(square / count), 0.06);
}

}  // namespace
}  // namespace mien::virt
