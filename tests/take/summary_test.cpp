#include "mien/take/summary.h"

#include "tests/take/example_take.h"

namespace mien::take::summary_test {
namespace {

std::vector<DeviceTime> at_ms(std::initializer_list<int> list) {
  std::vector<DeviceTime> times;
  for (const int ms : list) times.push_back(test::device_ms(ms));
  return times;
}

TEST(SensorSummary, CountsWhatIsMissing) {
  // 10 ms apart; 40 and 50 are missing, 20 came twice, 70 came late.
  const auto summary = summarise_sensor("a", at_ms({0, 10, 20, 20, 30, 60, 80, 70, 90}));
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
  EXPECT_EQ(summarise_sensor("a", {}).rate_hz, 0);
  const auto one = summarise_sensor("a", at_ms({5}));
  EXPECT_EQ(one.samples, 1U);
  EXPECT_EQ(one.rate_hz, 0);
  EXPECT_EQ(one.loss, 0);
  const auto twice = summarise_sensor("a", at_ms({5, 5, 5}));
  EXPECT_EQ(twice.doubled, 2U);
  EXPECT_EQ(twice.rate_hz, 0);
}

TEST(SensorSummary, TakesJitterForNoGap) {
  const auto summary = summarise_sensor("a", at_ms({0, 10, 21, 29, 41, 50, 64, 70}));
  EXPECT_EQ(summary.gaps, 0U);
  EXPECT_EQ(summary.lost, 0U);
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
