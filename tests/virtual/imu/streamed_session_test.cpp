// A session that is simulated and received a second at a time is the one that is played at once.
#include "mien/virtual/imu/streamed_session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "mien/virtual/imu/imu_session.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt::streamed_session_test {
namespace {

constexpr double kShortS = 4;

performer::PrologueMotion prologue_and(int frames) {
  return performer::with_prologue(test::talking(frames), performer::PrologueKind::brief, Random(3));
}

/// Faults that let packets overtake one another, and lose some.
DeviceFaults bad_radio() {
  DeviceFaults faults = test::mild_faults();
  faults.radio_delay_ms = 40;
  faults.packet_loss = 0.2;
  return faults;
}

/// What is kept of a streamed session, and the most entries that one stretch had.
struct Streamed {
  VirtualSession session;
  std::size_t largest = 0;
};

Streamed stream(const sensor::Rig& rig, performer::LongMotion motion, const DeviceFaults& faults) {
  StreamedSession streamed =
      StreamedSession::create(rig, test::three_sites(), faults, std::move(motion), Random(11)).value();
  Streamed out;
  while (!streamed.done()) {
    VirtualSession next = streamed.next().value();
    out.largest = std::max(out.largest, next.entries.size());
    std::ranges::move(next.entries, std::back_inserter(out.session.entries));
    std::ranges::move(next.samples, std::back_inserter(out.session.samples));
    std::ranges::move(next.ticks, std::back_inserter(out.session.ticks));
    std::ranges::move(next.truth, std::back_inserter(out.session.truth));
    std::ranges::move(next.events, std::back_inserter(out.session.events));
    out.session.motion_start = next.motion_start;
  }
  return out;
}

void expect_same(const VirtualSession& one, const VirtualSession& other) {
  EXPECT_EQ(one.motion_start, other.motion_start);
  ASSERT_EQ(one.entries.size(), other.entries.size());
  for (std::size_t i = 0; i < one.entries.size(); ++i) {
    ASSERT_EQ(one.entries[i].id, other.entries[i].id);
    ASSERT_EQ(one.entries[i].arrival, other.entries[i].arrival);
    ASSERT_EQ(one.entries[i].bytes, other.entries[i].bytes);
  }
  ASSERT_EQ(one.samples.size(), other.samples.size());
  for (std::size_t i = 0; i < one.samples.size(); ++i) {
    ASSERT_EQ(one.samples[i].entry, other.samples[i].entry);
    ASSERT_EQ(one.samples[i].sample.time, other.samples[i].sample.time);
    ASSERT_EQ(one.samples[i].sample.values, other.samples[i].sample.values);
  }
  ASSERT_EQ(one.ticks.size(), other.ticks.size());
  ASSERT_EQ(one.truth.size(), other.truth.size());
  for (std::size_t i = 0; i < one.ticks.size(); ++i) {
    ASSERT_EQ(one.ticks[i].index, other.ticks[i].index);
    ASSERT_EQ(one.ticks[i].after_entry, other.ticks[i].after_entry);
    ASSERT_EQ(one.ticks[i].fired, other.ticks[i].fired);
    ASSERT_EQ(one.truth[i].time, other.truth[i].time);
    ASSERT_EQ(one.truth[i].weights, other.truth[i].weights);
    ASSERT_EQ(one.truth[i].evaluated, other.truth[i].evaluated);
  }
  ASSERT_EQ(one.events.size(), other.events.size());
  for (std::size_t i = 0; i < one.events.size(); ++i) {
    EXPECT_EQ(one.events[i].kind, other.events[i].kind);
    EXPECT_EQ(one.events[i].begin, other.events[i].begin);
    EXPECT_EQ(one.events[i].end, other.events[i].end);
  }
}

TEST(StreamedSession, IsTheSessionThatIsPlayedAtOnce) {
  const sensor::Rig rig = test::three_sensors();
  const performer::PrologueMotion motion = prologue_and(150);
  for (const DeviceFaults& faults : {test::mild_faults(), bad_radio()}) {
    const Streamed streamed = stream(rig, performer::LongMotion(motion), faults);
    expect_same(streamed.session, play_devices(motion, test::three_sites(), rig, faults, Random(11)).value());
  }
}

/// Twelve seconds in three pieces.
performer::LongMotion three_pieces() {
  const performer::PrologueMotion first = prologue_and(240);
  return {first,
          {.draw = [](std::size_t index) { return index < 3 ? test::talking(240) : face::Motion(); },
           .duration_s = first.times.motion_start_s + 2 * kShortS + 239 / 60.0,
           .piece_s = kShortS}};
}

TEST(StreamedSession, OfThreePiecesHoldsNoMoreThanASecond) {
  const sensor::Rig rig = test::three_sensors();
  const Streamed one = stream(rig, three_pieces(), test::mild_faults());
  expect_same(one.session, stream(rig, three_pieces(), test::mild_faults()).session);
  // Sixty packets a second of each sensor; the last stretch also has what was under way.
  EXPECT_LE(one.largest, 3 * 75);
  const std::vector<take::TruthFrame>& truth = one.session.truth;
  const auto evaluated = std::ranges::count(truth, true, &take::TruthFrame::evaluated);
  EXPECT_NEAR(static_cast<double>(evaluated), 3 * 240, 2);
}

}  // namespace
}  // namespace mien::virt::streamed_session_test
