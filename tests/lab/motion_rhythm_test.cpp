#include "lab/motion_rhythm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace mien::lab::motion_rhythm_test {
namespace {

using face::shape;

constexpr double kRate_hz = 30;

MotionRun still(std::size_t frames) {
  MotionRun run(frames);
  for (face::BlendshapeWeights& weights : run)
    weights[shape("eyeBlink_L")] = weights[shape("eyeBlink_R")] = 0.3F;
  return run;
}

/// Lids close in three frames and open in six.
void blink(MotionRun& run, std::size_t at, float peak, float side = 0) {
  for (std::size_t i = 0; i <= 9; ++i) {
    const float share = i < 3 ? static_cast<float>(i) / 3 : 1 - static_cast<float>(i - 3) / 6;
    for (const auto& [k, more] : {std::pair{shape("eyeBlink_L"), side}, std::pair{shape("eyeBlink_R"), 0.0F}})
      run[at + i][k] = 0.3F + share * (peak + more - 0.3F);
  }
}

TEST(MotionRhythm, OfAStillFaceIsRest) {
  const std::array runs = {still(300)};
  const MotionRhythm rhythm = motion_rhythm(runs, kRate_hz);
  EXPECT_DOUBLE_EQ(rhythm.rest_share, 1);
  EXPECT_NEAR(rhythm.still_share, 1, 1e-9);
  EXPECT_EQ(rhythm.blinks_per_min, 0);
  EXPECT_EQ(rhythm.expression_s, 0);
  EXPECT_EQ(rhythm.speed_tail, 0);
  EXPECT_EQ(rhythm.slowest + rhythm.slow + rhythm.quick + rhythm.quickest, 0);
}

TEST(MotionRhythm, OfNothingIsNothing) {
  EXPECT_EQ(motion_rhythm({}, kRate_hz).rest_share, 0);
  const std::array runs = {MotionRun(1)};
  EXPECT_EQ(motion_rhythm(runs, kRate_hz).rest_share, 1);
}

TEST(MotionRhythm, FindsBlinksAboveLidsThatRestHalfClosed) {
  std::array runs = {still(900), still(900)};
  for (std::size_t i = 0; i < 8; ++i) blink(runs[i % 2], 50 + 100 * i, 0.9F, 0.06F);
  const MotionRhythm rhythm = motion_rhythm(runs, kRate_hz);
  EXPECT_NEAR(rhythm.blinks_per_min, 8, 1e-9);
  EXPECT_NEAR(rhythm.blink_s, 5 / kRate_hz, 1.1 / kRate_hz);
  EXPECT_NEAR(rhythm.blink_closing_share, 0.35, 0.1);
  EXPECT_NEAR(rhythm.blink_peak, 0.93, 1e-3);
  EXPECT_NEAR(rhythm.blink_side_difference, 0.06, 1e-3);
}

TEST(MotionRhythm, LidsThatStayShutAreNoBlink) {
  std::array runs = {still(300)};
  for (std::size_t i = 100; i < 200; ++i)
    runs[0][i][shape("eyeBlink_L")] = runs[0][i][shape("eyeBlink_R")] = 1;
  EXPECT_EQ(motion_rhythm(runs, kRate_hz).blinks_per_min, 0);
}

TEST(MotionRhythm, MeasuresHowLongExpressionsLast) {
  std::array runs = {still(1000)};
  for (const std::size_t begin : {100, 300, 500})
    for (std::size_t i = begin; i < begin + 60; ++i) runs[0][i][shape("mouthSmile_L")] = 0.5F;
  const MotionRhythm rhythm = motion_rhythm(runs, kRate_hz);
  EXPECT_NEAR(rhythm.expression_s, 2, 1e-6);
  EXPECT_NEAR(rhythm.still_share, 0.82, 1e-6);
}

TEST(MotionRhythm, TellsQuickFromSlow) {
  const auto wave = [](double period_s) {
    MotionRun run(1800);
    for (std::size_t i = 0; i < run.size(); ++i)
      run[i][shape("jawOpen")] = static_cast<float>(
          0.5 + 0.4 * std::sin(2 * std::numbers::pi * static_cast<double>(i) / kRate_hz / period_s));
    return std::array{std::move(run)};
  };
  EXPECT_GT(motion_rhythm(wave(20), kRate_hz).slowest, 0.8);
  EXPECT_GT(motion_rhythm(wave(2), kRate_hz).slow, 0.7);
  EXPECT_GT(motion_rhythm(wave(0.5), kRate_hz).quick, 0.6);
  EXPECT_GT(motion_rhythm(wave(0.15), kRate_hz).quickest, 0.8);
  EXPECT_NEAR(motion_rhythm(wave(2), kRate_hz).speed_tail, std::numbers::sqrt2, 0.02);
}

}  // namespace
}  // namespace mien::lab::motion_rhythm_test
