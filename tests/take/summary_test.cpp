#include "mien/take/summary.h"

#include "tests/take/example_take.h"

namespace mien::take::summary_test {
namespace {

/// Samples that came at once, numbered as they came.
std::vector<SampleTime> at_ms(std::initializer_list<int> list) {
  std::vector<SampleTime> times;
  for (const int ms : list)
    times.push_back({test::device_ms(ms), test::host_ms(ms), static_cast<std::uint32_t>(times.size())});
  return times;
}

TEST(SensorSummary, CountsWhatIsMissing) {
  // 10 ms apart; 40 and 50 are missing, 20 came twice, 70 came late.
  const auto summary = summarise_sensor("a", at_ms({0, 10, 20, 20, 30, 60, 80, 70, 90}), false);
  EXPECT_EQ(summary.samples, 9U);
  EXPECT_EQ(summary.doubled, 1U);
  EXPECT_NEAR(summary.rate_hz, 100, 1e-9);
  EXPECT_EQ(summary.gaps, 1U);
  EXPECT_EQ(summary.lost, 2U);
  EXPECT_NEAR(summary.loss, 0.2, 1e-12);
  EXPECT_NEAR(summary.longest_gap_s, 0.03, 1e-12);
  EXPECT_NEAR(summary.begin_s, 0, 1e-12);
  EXPECT_NEAR(summary.end_s, 0.09, 1e-12);
}

TEST(SensorSummary, SaysNothingOfSensorsThatSaidNothing) {
  EXPECT_EQ(summarise_sensor("a", {}, false).rate_hz, 0);
  const auto one = summarise_sensor("a", at_ms({5}), false);
  EXPECT_EQ(one.samples, 1U);
  EXPECT_EQ(one.rate_hz, 0);
  EXPECT_EQ(one.loss, 0);
  const auto twice = summarise_sensor("a", at_ms({5, 5, 5}), false);
  EXPECT_EQ(twice.doubled, 2U);
  EXPECT_EQ(twice.rate_hz, 0);
}

TEST(SensorSummary, TakesJitterForNoGap) {
  const auto summary = summarise_sensor("a", at_ms({0, 10, 21, 29, 41, 50, 64, 70}), false);
  EXPECT_EQ(summary.gaps, 0U);
  EXPECT_EQ(summary.lost, 0U);
}

TEST(SensorSummary, ALeapOfTheClockIsNoLoss) {
  std::vector<SampleTime> times;
  for (int i = 0; i < 300; ++i) {
    // An hour ahead after a second, and from the beginning after another one.
    const int device_ms = i < 100 ? 10 * i + 100'000 : i < 200 ? 10 * i + 3'700'000 : 10 * (i - 200);
    times.push_back({test::device_ms(device_ms), test::host_ms(10 * i)});
  }
  const auto summary = summarise_sensor("a", times, false);
  EXPECT_EQ(summary.leaps, 2U);
  EXPECT_EQ(summary.lost + summary.gaps, 0U);
  EXPECT_NEAR(summary.heard_s, 3 * 0.99, 1e-9);
  EXPECT_NEAR(summary.begin_s, 100, 1e-9);
  EXPECT_NEAR(summary.end_s, 0.99, 1e-9);
  // Ten seconds without it are a gap, since so much went by.
  for (int i = 0; i < 100; ++i)
    times.push_back({test::device_ms(10'000 + 10 * i), test::host_ms(12'000 + 10 * i)});
  const auto silent = summarise_sensor("a", times, false);
  EXPECT_EQ(silent.leaps, 2U);
  EXPECT_EQ(silent.gaps, 1U);
  EXPECT_EQ(silent.lost, 900U);
}

TEST(SensorSummary, OfNumberedSamplesTheNumbersTellWhatIsMissing) {
  std::vector<SampleTime> times;
  std::uint32_t number = 0xFFFFFFF0U;
  for (int i = 0; i < 100; ++i) {
    if (i >= 20 && i < 50) continue;  // No face, and no numbers.
    if (i == 70) number += 2;         // Lost.
    times.push_back({test::device_ms(16 * i), test::host_ms(16 * i), number++});
  }
  const auto summary = summarise_sensor("phone", times, true);
  EXPECT_EQ(summary.lost, 2U);
  EXPECT_EQ(summary.gaps, 1U);
  EXPECT_EQ(summarise_sensor("phone", times, false).lost, 30U) << "by its times";
}

TEST(EventGroups, FoldWhatSaysTheSame) {
  const auto event = [](const char* kind, int begin_ms, int end_ms, const char* json = "") {
    return Event{kind, test::device_ms(begin_ms), test::device_ms(end_ms), json};
  };
  const std::vector<Event> events = {
      event("lost", 300, 300, R"({"sensor": "a"})"), event("nod", 100, 250),
      event("lost", 310, 310, R"({"sensor": "b"})"), event("lost", 500, 500, R"({"sensor": "a"})"),
      event("back", 400, 400, R"({"sensor": "a"})"), event("lost", 290, 700, R"({"sensor": "a"})")};
  const std::vector<EventGroup> groups = group_events(events);
  ASSERT_EQ(groups.size(), 4U);
  EXPECT_EQ(groups[0].first.kind, "nod");
  EXPECT_EQ(groups[0].count, 1U);
  EXPECT_EQ(groups[0].end, test::device_ms(250));
  EXPECT_EQ(groups[1].count, 3U);
  EXPECT_EQ(groups[1].first.begin, test::device_ms(290));
  EXPECT_EQ(groups[1].end, test::device_ms(700));
  EXPECT_EQ(groups[2].first.json, R"({"sensor": "b"})");
  EXPECT_EQ(groups[3].first.kind, "back");
  EXPECT_TRUE(group_events({}).empty());
}

TEST(Summary, CountsEveryTrack) {
  const mien::test::Folder folder;
  test::write_example(folder / "a.mien", 100);
  const auto take = Take::open(folder / "a.mien");
  ASSERT_TRUE(take);
  const auto summary = summarise(*take);
  ASSERT_TRUE(summary) << summary.error().message();
  EXPECT_EQ(summary->entries, 100U);
  EXPECT_EQ(summary->samples, 100U);
  EXPECT_EQ(summary->ticks, 6U);
  EXPECT_EQ(summary->begin, take->ticks()->front().frame);
  EXPECT_EQ(summary->truth_frames, 6U);
  EXPECT_EQ(summary->truth_lost, 1U);
  EXPECT_EQ(summary->truth_evaluated, 3U);
  EXPECT_NEAR(summary->audio_s, 0.01, 1e-12);
  EXPECT_NEAR(summary->duration_s, 0.099, 1e-12);
  ASSERT_EQ(summary->sensors.size(), 2U);
  EXPECT_EQ(summary->sensors[0].name, "a");
  EXPECT_EQ(summary->sensors[0].samples, 50U);
  EXPECT_NEAR(summary->sensors[0].rate_hz, 500, 1e-6);
  EXPECT_EQ(summary->sensors[0].lost, 0U);
}

}  // namespace
}  // namespace mien::take::summary_test
