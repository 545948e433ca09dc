#include "mien/shaping/blink_peaks.h"

#include <gtest/gtest.h>

#include <initializer_list>

#include "mien/core/random.h"

namespace mien::shaping::blink_peaks_test {
namespace {

constexpr float kRest = 0.3F;

void add(BlinkPeaks& peaks, std::initializer_list<float> weights) {
  for (const float weight : weights) peaks.add(weight, kRest);
}

void blink(BlinkPeaks& peaks, float peak) {
  add(peaks, {kRest, 0.5F * (kRest + peak), peak, 0.5F * (kRest + peak), kRest});
}

TEST(BlinkPeaks, SayNothingBeforeThreeBlinks) {
  BlinkPeaks peaks;
  EXPECT_EQ(peaks.largest(), std::nullopt);
  blink(peaks, 0.9F);
  blink(peaks, 0.7F);
  EXPECT_EQ(peaks.largest(), std::nullopt);
  blink(peaks, 0.8F);
  EXPECT_EQ(peaks.largest(), 0.9F);
}

TEST(BlinkPeaks, OfTheLastSixteenTheLargestCounts) {
  BlinkPeaks peaks;
  blink(peaks, 0.95F);
  for (int i = 0; i < 15; ++i) blink(peaks, 0.8F);
  EXPECT_EQ(peaks.largest(), 0.95F);
  blink(peaks, 0.8F);
  EXPECT_EQ(peaks.largest(), 0.8F);
}

TEST(BlinkPeaks, ABlinkEndsWhereItIsNearlyOpen) {
  BlinkPeaks peaks;
  // Up and down above the rest + 0.075 at which it ends: one closure, its highest peak.
  add(peaks, {0.3F, 0.6F, 0.8F, 0.4F, 0.9F, 0.4F, 0.7F, 0.3F});
  blink(peaks, 0.5F);
  EXPECT_EQ(peaks.largest(), std::nullopt);
  blink(peaks, 0.5F);
  EXPECT_EQ(peaks.largest(), 0.9F);
}

TEST(BlinkPeaks, NoiseIsNoBlink) {
  BlinkPeaks peaks;
  Random random(7);
  for (int i = 0; i < 10000; ++i) peaks.add(kRest + static_cast<float>(random.normal(0, 0.03)), kRest);
  EXPECT_EQ(peaks.largest(), std::nullopt);
}

TEST(BlinkPeaks, OneOfWhichAFrameIsLostDoesNotCount) {
  BlinkPeaks peaks;
  for (int i = 0; i < 5; ++i) {
    add(peaks, {0.3F, 0.6F});
    peaks.lose();  // The peak.
    add(peaks, {0.7F, 0.5F, 0.3F});
  }
  EXPECT_EQ(peaks.largest(), std::nullopt);
  for (int i = 0; i < 3; ++i) {
    blink(peaks, 0.8F);
    peaks.lose();  // Between two it does no harm.
  }
  EXPECT_EQ(peaks.largest(), 0.8F);
}

TEST(BlinkPeaks, BeginAnew) {
  BlinkPeaks peaks;
  for (int i = 0; i < 3; ++i) blink(peaks, 0.8F);
  peaks.reset();
  EXPECT_EQ(peaks.largest(), std::nullopt);
  // One that was under way when it began is not told by its peak.
  add(peaks, {0.9F, 0.3F});
  blink(peaks, 0.5F);
  blink(peaks, 0.5F);
  EXPECT_EQ(peaks.largest(), std::nullopt);
}

}  // namespace
}  // namespace mien::shaping::blink_peaks_test
