// A session heard through a worse network, from devices in trouble.
#include "lab/imu/impair.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/imu/packets/packet.h"
#include "mien/imu/pipeline.h"
#include "tests/imu/clocked_pipeline.h"
#include "tests/lab/imu/impaired_session.h"

namespace mien::lab::impair_test {
namespace {

using test::expect_sound;
using test::impaired;
using test::session;

TEST(Impair, APerfectNetworkGivesTheSessionBack) {
  const virt::VirtualSession same = impaired({});
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
  const virt::VirtualSession worse = impaired({.loss = 0.1,
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
  const virt::NetworkSettings settings{.loss = 0.1, .jitter_ms = 20, .corrupted = 0.05};
  const virt::VirtualSession one = impaired(settings, {}, 8);
  const virt::VirtualSession same = impaired(settings, {}, 8);
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
  const virt::VirtualSession worse = impaired({.corrupted = 0.1, .truncated = 0.1});
  EXPECT_EQ(worse.entries.size(), session().entries.size());
  std::size_t whole = 0;
  for (const take::LogEntry& entry : worse.entries) whole += imu::parse_packet(entry.bytes) ? 1 : 0;
  EXPECT_NEAR(static_cast<double>(whole), 0.81 * static_cast<double>(worse.entries.size()), 120);
  EXPECT_EQ(worse.samples.size(), 4 * whole);
}

TEST(Impair, RefusesASessionWithoutTruth) {
  const auto out = impair(virt::VirtualSession{}, virt::test::three_sensors(), {}, Random(1));
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().code, ErrorCode::bad_usage);
}

TEST(Impair, ThePipelineStillFindsTheSkinThroughABadNetwork) {
  const virt::VirtualSession worse = impaired({.loss = 0.1, .jitter_ms = 10});
  imu::testing_head::ClockedPipeline pipeline(virt::test::three_sensors());
  for (const take::Event& event : worse.events)
    pipeline.mark(tracker::step_named(event.kind), event.begin, event.end);
  const auto sites = virt::test::three_sites();
  model::FeatureFrame frame;
  double square = 0;
  double count = 0;
  auto next = worse.samples.begin();
  for (std::size_t i = 0; i < worse.ticks.size(); ++i) {
    for (; next != worse.samples.end() && next->entry <= worse.ticks[i].after_entry; ++next)
      pipeline.add(next->arrival, next->sample);
    pipeline.tick(worse.ticks[i].frame, frame);
    const take::TruthFrame& truth = worse.truth[i];
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
}  // namespace mien::lab::impair_test
