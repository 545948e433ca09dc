#include "mien/train/mel_augmentation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace mien::train::mel_augmentation_test {
namespace {

using speech::kMelBands;

/// Silence, a vowel of two formants, silence.
std::vector<float> spoken() {
  std::vector<float> frames;
  for (int f = 0; f < 60; ++f)
    for (std::size_t b = 0; b < kMelBands; ++b) {
      const bool loud = f >= 20 && f < 40;
      const double formants = std::exp(-0.1 * std::pow(static_cast<double>(b) - 12, 2)) +
                              std::exp(-0.1 * std::pow(static_cast<double>(b) - 24, 2));
      frames.push_back(loud ? static_cast<float>(-8 + 5 * formants) : speech::LogMel::kLogFloor);
    }
  return frames;
}

TEST(MelAugmentation, EveryWindowIsAnotherAndTheSameSeedTheSame) {
  std::vector<float> one = spoken(), two = spoken(), other = spoken();
  Random first(1), again(1), second(2);
  augment_mel(one, {}, first);
  augment_mel(two, {}, again);
  augment_mel(other, {}, second);
  EXPECT_EQ(one, two);
  EXPECT_NE(one, other);
}

TEST(MelAugmentation, StaysFiniteAboveTheFloorAndLoudWhereSpeechIs) {
  Random random(3);
  const std::vector<float> noise(spoken().size(), -5);
  for (int i = 0; i < 200; ++i) {
    std::vector<float> frames = spoken();
    augment_mel(frames, i % 2 == 0 ? std::span<const float>(noise) : std::span<const float>(), random);
    double before = -100, during = -100;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      ASSERT_TRUE(std::isfinite(frames[k]));
      ASSERT_GE(frames[k], speech::LogMel::kLogFloor);
      const std::size_t frame = k / kMelBands;
      if (frame < 20) before = std::max(before, double{frames[k]});
      if (frame >= 20 && frame < 40) during = std::max(during, double{frames[k]});
    }
    EXPECT_GT(during, before - 3) << i;
  }
}

TEST(MelAugmentation, SilenceStaysSilent) {
  std::vector<float> frames(20 * kMelBands, speech::LogMel::kLogFloor);
  Random random(3);
  for (int i = 0; i < 20; ++i) augment_mel(frames, {}, random);
  for (const float value : frames) EXPECT_TRUE(std::isfinite(value));
}

}  // namespace
}  // namespace mien::train::mel_augmentation_test
