#include "mien/speech/log_mel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/allocation_count.h"

namespace mien::speech::log_mel_test {
namespace {

/// The `index`th block of a sine.
Block sine(double hz, double amplitude, int index) {
  Block block;
  for (std::size_t i = 0; i < kBlockSamples; ++i) {
    const double t = (static_cast<double>(index) * kBlockSamples + static_cast<double>(i)) / kRateHz;
    block[i] = static_cast<std::int16_t>(
        std::lround(amplitude * (kFullScale - 1) * std::sin(2 * std::numbers::pi * hz * t)));
  }
  return block;
}

MelFrame of_sine(double hz, double amplitude) {
  LogMel mel;
  MelFrame frame{};
  for (int i = 0; i < 5; ++i) frame = mel.push(sine(hz, amplitude, i)).back();
  return frame;
}

std::size_t loudest(const MelFrame& frame) {
  return static_cast<std::size_t>(std::ranges::max_element(frame) - frame.begin());
}

TEST(LogMel, SilenceIsTheFloor) {
  LogMel mel;
  for (const MelFrame& frame : mel.push({}))
    for (const float band : frame) EXPECT_EQ(band, LogMel::kLogFloor);
}

TEST(LogMel, ASineIsLoudInItsBandAlone) {
  const double low = 2595 * std::log10(1 + LogMel::kLowest_hz / 700),
               high = 2595 * std::log10(1 + LogMel::kHighest_hz / 700);
  for (const double hz : {300.0, 1000.0, 3000.0, 7000.0}) {
    const MelFrame frame = of_sine(hz, 0.5);
    // Its middle is the (b + 1)th of 41 equal steps on the mel scale.
    const double place = (2595 * std::log10(1 + hz / 700) - low) / (high - low) * (kMelBands + 1) - 1;
    EXPECT_NEAR(static_cast<double>(loudest(frame)), place, 0.75) << hz;
    EXPECT_GT(frame[loudest(frame)], -4) << "half of full scale is -1.4, in two bands at worst";
    EXPECT_LT(frame[loudest(frame)], 0);
    for (std::size_t b = 0; b < kMelBands; ++b)
      if (std::abs(static_cast<double>(b) - place) > 6) {
        EXPECT_LT(frame[b], frame[loudest(frame)] - 6) << hz << ", band " << b;
      }
  }
}

TEST(LogMel, IsALogarithmOfPower) {
  const MelFrame loud = of_sine(1000, 0.8), quiet = of_sine(1000, 0.08);
  EXPECT_NEAR(loud[loudest(loud)] - quiet[loudest(loud)], std::log(100.0), 0.01);
}

TEST(LogMel, AFrameEndsWithTheNewestSample) {
  LogMel mel;
  Block click{};
  click[kBlockSamples - 100] = 30'000;  // In the last 10 ms.
  const auto frames = mel.push(click);
  EXPECT_EQ(*std::ranges::max_element(frames[0]), LogMel::kLogFloor);
  EXPECT_GT(*std::ranges::max_element(frames[1]), LogMel::kLogFloor);
  // 25 ms later it is gone.
  EXPECT_GT(*std::ranges::max_element(mel.push({})[0]), LogMel::kLogFloor);
  EXPECT_EQ(*std::ranges::max_element(mel.push({})[0]), LogMel::kLogFloor);
}

TEST(LogMel, StaysWithinItsRangeAndBeginsAnew) {
  LogMel mel;
  Block block;
  block.fill(-32'768);
  for (const MelFrame& frame : mel.push(block))
    for (const float band : frame) EXPECT_TRUE(std::isfinite(band) && band >= LogMel::kLogFloor && band < 3);
  const auto first = LogMel().push(sine(440, 0.3, 0));
  mel.reset();
  EXPECT_EQ(mel.push(sine(440, 0.3, 0)), first);
  const std::size_t before = test::allocation_count();
  (void)mel.push(sine(440, 0.3, 1));
  EXPECT_EQ(test::allocation_count(), before);
}

}  // namespace
}  // namespace mien::speech::log_mel_test
