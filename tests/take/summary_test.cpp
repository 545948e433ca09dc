#include "mien/take/summary.h"

#include "tests/take/example_take.h"

namespace mien::take {
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

TEST(Summary, CountsEveryTrack) {
  const test::Folder folder;
  test::write_example(folder / "a.mien", 100);
  const auto take = Take::open(folder / "a.mien");
  ASSERT_TRUE(take);
  const auto summary = summarise(*take);
  ASSERT_TRUE(summary) << summary.error().message();
  EXPECT_EQ(summary->entries, 100U);
  EXPECT_EQ(summary->samples, 100U);
  EXPECT_EQ(summary->ticks, 6U);
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
}  // namespace mien::take
