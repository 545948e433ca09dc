#include "mien/performer/blinks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace mien::performer::blink_test {
namespace {

TEST(Blinks, RateIsTheAskedOne) {
  for (const double rate : {10.0, 17.0, 25.0}) {
    const double minutes = 120;
    const auto blinks = draw_blinks(60 * minutes, rate, {}, Random(3));
    EXPECT_NEAR(static_cast<double>(blinks.size()) / minutes, rate, 0.06 * rate);
  }
}

TEST(Blinks, IntervalsAreLogNormal) {
  const auto blinks = draw_blinks(36'000, 15, {}, Random(4));
  std::vector<double> logs;
  for (std::size_t i = 1; i < blinks.size(); ++i)
    logs.push_back(std::log(blinks[i].begin_s - blinks[i - 1].begin_s));
  const double mean = std::accumulate(logs.begin(), logs.end(), 0.0) / static_cast<double>(logs.size());
  double variance = 0;
  double skew = 0;
  for (const double x : logs) variance += (x - mean) * (x - mean) / static_cast<double>(logs.size());
  for (const double x : logs)
    skew += std::pow((x - mean) / std::sqrt(variance), 3) / static_cast<double>(logs.size());
  EXPECT_NEAR(std::sqrt(variance), 0.65, 0.05);
  EXPECT_NEAR(skew, 0, 0.25);  // Symmetric in the logarithm.
}

TEST(Blinks, TimesAreThoseOfPeople) {
  const auto blinks = draw_blinks(3600, 20, {}, Random(5));
  std::size_t partial = 0;
  for (std::size_t i = 0; i < blinks.size(); ++i) {
    EXPECT_GE(blinks[i].closing_s, 0.08);
    EXPECT_LE(blinks[i].closing_s, 0.10);
    EXPECT_GE(blinks[i].opening_s, 0.15);
    EXPECT_LE(blinks[i].opening_s, 0.20);
    partial += blinks[i].peak < 0.8 ? 1 : 0;
    if (i > 0) {
      EXPECT_GT(blinks[i].begin_s, blinks[i - 1].end_s());
    }
  }
  EXPECT_NEAR(static_cast<double>(partial) / static_cast<double>(blinks.size()), 0.2, 0.05);
}

TEST(Blinks, FallOnCuesMoreOftenThanByChance) {
  std::vector<double> cues;
  for (double t = 3; t < 3600; t += 3) cues.push_back(t);
  const auto near_cue = [&](const std::vector<face::Blink>& blinks) {
    double count = 0;
    for (const face::Blink& blink : blinks)
      count += std::abs(std::remainder(blink.begin_s, 3.0)) < 0.05 ? 1 : 0;
    return count / static_cast<double>(blinks.size());
  };
  EXPECT_LT(near_cue(draw_blinks(3600, 15, {}, Random(6))), 0.08);
  EXPECT_GT(near_cue(draw_blinks(3600, 15, cues, Random(6))), 0.2);
}

TEST(Blinks, LidsReachThePeakAndComeBack) {
  const face::Blink blink{
      .begin_s = 0.5, .closing_s = 0.09, .hold_s = 0.04, .opening_s = 0.17, .peak = 1, .right_lag_s = 0};
  const auto lids = lid_tracks(std::vector{blink}, 90);
  EXPECT_EQ(lids.front()[0], 0.0F);
  EXPECT_EQ(lids.back()[1], 0.0F);
  float largest = 0;
  for (const auto& lid : lids) largest = std::max(largest, lid[0]);
  EXPECT_GT(largest, 0.97F);
}

TEST(Blinks, NoRateNoBlinks) {
  EXPECT_TRUE(draw_blinks(100, 0, {}, Random(1)).empty());
}

}  // namespace
}  // namespace mien::performer::blink_test
