#include "mien/core/monotone_cubic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mien/core/random.h"

namespace mien::monotone_cubic_test {
namespace {

TEST(MonotoneCubic, OneSampleIsFlat) {
  const std::vector<double> t = {3.0};
  const std::vector<float> y = {0.7F};
  std::vector<float> slope = {99.0F};
  monotone_slopes(t, y, slope);
  EXPECT_EQ(slope[0], 0.0F);
  monotone_slopes({}, {}, {});
}

TEST(MonotoneCubic, SlopesAreTheHarmonicMean) {
  const std::vector<double> t = {0, 1, 2, 3};
  const std::vector<float> y = {0, 1, 3, 4};
  std::vector<float> slope(4);
  monotone_slopes(t, y, slope);
  // Even spacing: the harmonic mean of the two secants, 2 / (1/1 + 1/2).
  EXPECT_FLOAT_EQ(slope[1], 4.0F / 3.0F);
  EXPECT_FLOAT_EQ(slope[2], 4.0F / 3.0F);
  EXPECT_EQ(slope[0], 0.0F);
  EXPECT_EQ(slope[3], 0.0F);
}

TEST(MonotoneCubic, IsFlatAtAPeak) {
  const std::vector<double> t = {0, 1, 2};
  const std::vector<float> y = {0, 1, 0};
  std::vector<float> slope(3);
  monotone_slopes(t, y, slope);
  EXPECT_EQ(slope[1], 0.0F);
}

TEST(MonotoneCubic, MeetsItsSamples) {
  EXPECT_FLOAT_EQ(hermite(1.0, 0.25F, 3.0F, 1.5, 0.75F, -2.0F, 1.0), 0.25F);
  EXPECT_FLOAT_EQ(hermite(1.0, 0.25F, 3.0F, 1.5, 0.75F, -2.0F, 1.5), 0.75F);
}

TEST(MonotoneCubic, HasTheSlopesThatWereAsked) {
  const double e = 1e-5;
  const double at_start = (hermite(0, 0, 0.5F, 2, 1, -0.25F, e) - hermite(0, 0, 0.5F, 2, 1, -0.25F, 0)) / e;
  EXPECT_NEAR(at_start, 0.5, 1e-2);
}

// Whatever the samples and however uneven their times, between two of them the curve stays between them.
TEST(MonotoneCubic, NeverOvershoots) {
  Random random(7);
  for (int round = 0; round < 200; ++round) {
    std::vector<double> t = {0};
    std::vector<float> y = {static_cast<float>(random.uniform())};
    for (int i = 1; i < 20; ++i) {
      t.push_back(t.back() + random.uniform(0.001, 0.2));
      y.push_back(random.chance(0.2) ? y.back() : static_cast<float>(random.uniform()));
    }
    std::vector<float> slope(t.size());
    monotone_slopes(t, y, slope);
    for (std::size_t i = 0; i + 1 < t.size(); ++i) {
      const float low = std::min(y[i], y[i + 1]);
      const float high = std::max(y[i], y[i + 1]);
      for (double u = 0; u <= 1; u += 0.05) {
        const float v =
            hermite(t[i], y[i], slope[i], t[i + 1], y[i + 1], slope[i + 1], t[i] + u * (t[i + 1] - t[i]));
        ASSERT_GE(v, low - 1e-6F);
        ASSERT_LE(v, high + 1e-6F);
      }
    }
  }
}

}  // namespace
}  // namespace mien::monotone_cubic_test
