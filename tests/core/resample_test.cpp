#include "mien/core/resample.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

namespace mien::core::resample_test {
namespace {

/// A second.
Sound tone(std::uint32_t rate_hz, double frequency_hz) {
  Sound sound{.rate_hz = rate_hz, .samples = std::vector<float>(rate_hz)};
  for (std::size_t i = 0; i < rate_hz; ++i)
    sound.samples[i] = static_cast<float>(
        0.5 * std::sin(2 * std::numbers::pi * frequency_hz * static_cast<double>(i) / rate_hz));
  return sound;
}

TEST(Resample, IsNeitherLateNorLouder) {
  for (const auto& [from, to] : {std::pair<std::uint32_t, std::uint32_t>{16'000, 8'000},
                                 {48'000, 8'000},
                                 {44'100, 8'000},
                                 {22'050, 16'000},
                                 {8'000, 44'100},
                                 {44'099, 8'000}}) {
    const Sound out = resampled(tone(from, 500), to), expected = tone(to, 500);
    ASSERT_EQ(out.rate_hz, to);
    ASSERT_NEAR(static_cast<double>(out.samples.size()), to, 1) << from;
    // Off the ends, beyond which is silence.
    for (std::size_t i = to / 50; i + to / 50 < out.samples.size(); ++i)
      ASSERT_NEAR(out.samples[i], expected.samples[i], 2e-3) << from << " to " << to << ", " << i;
  }
}

TEST(Resample, TakesAwayWhatTheLowerRateCannotHold) {
  const Sound out = resampled(tone(16'000, 4'600), 8'000);
  for (std::size_t i = 200; i + 200 < out.samples.size(); ++i) ASSERT_NEAR(out.samples[i], 0, 1e-3) << i;
}

TEST(Resample, LeavesTheSameRateAlone) {
  const Sound sound = tone(8'000, 500);
  EXPECT_EQ(resampled(sound, 8'000).samples, sound.samples);
  EXPECT_TRUE(resampled(Sound{}, 8'000).samples.empty());
  EXPECT_TRUE(resampled(sound, 0).samples.empty());
  EXPECT_TRUE(resampled(Sound{.rate_hz = 16'000, .samples = {}}, 8'000).samples.empty());
}

}  // namespace
}  // namespace mien::core::resample_test
