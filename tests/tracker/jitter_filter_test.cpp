#include "mien/tracker/jitter_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "mien/core/random.h"

namespace mien::tracker::jitter_filter_test {
namespace {

const std::size_t kMouth = face::shape("mouthSmile_L"), kLid = face::shape("eyeBlink_L");

TEST(JitterFilter, TakesTremblingOutAndFollowsABlink) {
  JitterFilter calm;
  Random random(1);
  double trembling = 0, left = 0, largest_lag = 0;
  std::array<float, 4> in{}, out{};
  const auto third = [](const std::array<float, 4>& x) {
    return std::abs(x[3] - 3 * x[2] + 3 * x[1] - x[0]);
  };
  for (int f = 0; f < 600; ++f) {
    face::BlendshapeWeights weights;
    const float tremble = 0.3F + 0.02F * static_cast<float>(random.normal());
    // A lid closes within a tenth of a second.
    const float lid = f < 300 ? 0.0F : std::min(1.0F, static_cast<float>(f - 300) / 6);
    weights[kMouth] = tremble;
    weights[kLid] = lid;
    calm.apply(weights);
    std::rotate(in.begin(), in.begin() + 1, in.end());
    std::rotate(out.begin(), out.begin() + 1, out.end());
    in[3] = tremble;
    out[3] = weights[kMouth];
    if (f > 60) trembling += third(in), left += third(out);
    if (f == 306) largest_lag = 1 - weights[kLid];
    EXPECT_EQ(weights[face::shape("jawOpen")], 0);
  }
  EXPECT_LT(left, 0.15 * trembling);
  EXPECT_LT(largest_lag, 0.1) << "when it has closed";
}

TEST(JitterFilter, ALidThatFallsIsHalfShutWhenTheTruthIs) {
  JitterFilter calm;
  face::BlendshapeWeights weights;
  const auto half_shut_after = [&](std::size_t shape) {
    calm.reset();
    for (int f = 0; f < 100; ++f) {
      weights = {};
      // A network that is sure of a blink two frames after the lid has been half-way.
      weights[shape] = std::clamp(static_cast<float>(f - 8) / 6, 0.0F, 1.0F);
      calm.apply(weights);
      if (weights[shape] >= 0.5F) return f;
    }
    return 100;
  };
  EXPECT_LE(half_shut_after(kLid), 11);
  EXPECT_GT(half_shut_after(kMouth), half_shut_after(kLid));
}

TEST(JitterFilter, ALidThatStaysOrOpensGetsNoLead) {
  JitterFilter calm;
  face::BlendshapeWeights weights;
  float before = 1;
  for (int f = 0; f < 60; ++f) {
    weights[kLid] = std::max(0.0F, 1 - static_cast<float>(f) / 10);
    calm.apply(weights);
    EXPECT_LE(weights[kLid], before);
    EXPECT_GE(weights[kLid], std::max(0.0F, 1 - static_cast<float>(f) / 10));
    before = weights[kLid];
  }
}

/// How late a movement of one weight a second comes, as a weight, in the middle of it, after five seconds in
/// which all shapes tremble about it; and what is left of the trembling before.
struct Followed {
  double late = 0, left = 0;
};
Followed follow(double noise) {
  JitterFilter calm;
  Random random(7);
  Followed out;
  std::array<float, 4> shown{};
  for (int f = 0; f < 360; ++f) {
    const double truth = 0.2 + std::clamp((f - 300) / 60.0, 0.0, 0.6);
    face::BlendshapeWeights weights;
    for (float& weight : weights.values) weight = static_cast<float>(truth + noise * random.normal());
    calm.apply(weights);
    std::rotate(shown.begin(), shown.begin() + 1, shown.end());
    shown[3] = weights[kMouth];
    if (f > 200 && f < 300) out.left += std::abs(shown[3] - 3 * shown[2] + 3 * shown[1] - shown[0]) / 100;
    if (f > 315 && f <= 330) out.late += (truth - weights[kMouth]) / 15;
  }
  return out;
}

TEST(JitterFilter, WhatHardlyTremblesIsHardlyDelayed) {
  const Followed quiet = follow(0.0003), noisy = follow(0.003), noisier = follow(0.01);
  EXPECT_LT(quiet.late, 0.02);
  EXPECT_GT(noisy.late, 2 * quiet.late);
  EXPECT_GT(noisier.late, noisy.late);
  EXPECT_LT(noisier.left, 0.05 * 3.57 * 0.01) << "of the noise's own third difference";
  EXPECT_LT(noisy.left, 0.05 * 3.57 * 0.003);
}

TEST(JitterFilter, ALidIsDelayedAlikeWhateverTheNoise) {
  std::array<float, 2> half_shut{};
  for (const bool noisy : {false, true}) {
    JitterFilter calm;
    Random random(8);
    for (int f = 0; f < 305; ++f) {
      face::BlendshapeWeights weights;
      weights.values.fill(static_cast<float>(0.5 + (noisy ? 0.02 : 0.0002) * random.normal()));
      weights[kLid] = std::clamp(static_cast<float>(f - 300) / 6, 0.0F, 1.0F);
      calm.apply(weights);
      half_shut[noisy ? 1 : 0] = weights[kLid];
    }
  }
  EXPECT_GT(half_shut[0], 0.3F);
  EXPECT_EQ(half_shut[0], half_shut[1]);
}

TEST(NoiseLevel, FindsTheThirdDifferenceOfNoiseBesideMovement) {
  for (const float sigma : {0.0005F, 0.003F, 0.02F}) {
    NoiseLevel level(0.012F, 0.024F);
    Random random(9);
    float found = 0;
    for (int f = 0; f < 900; ++f) {
      face::BlendshapeWeights answer;
      const double moved = 0.3 + 0.25 * std::sin(0.05 * f);  // Half a cycle a second.
      for (float& weight : answer.values) weight = static_cast<float>(moved + sigma * random.normal());
      found = level.add(answer);
    }
    // Of white noise: sqrt(20) sigma, and its mean absolute value.
    EXPECT_NEAR(found / (std::sqrt(20.0F) * sigma * 0.798F), 1, 0.15) << sigma;
  }
}

TEST(NoiseLevel, AHeldShapeAndABrokenAnswerChangeNothing) {
  NoiseLevel level(0.011F, 0.5F);
  face::BlendshapeWeights held;
  for (int f = 0; f < 20; ++f) EXPECT_EQ(level.add(held), 0.011F);
  held[kMouth] = std::numeric_limits<float>::quiet_NaN();
  for (int f = 0; f < 5; ++f) EXPECT_EQ(level.add(held), 0.011F);
}

TEST(JitterFilter, ForgetsAtAReset) {
  JitterFilter calm, fresh;
  face::BlendshapeWeights one, two;
  one.values.fill(1);
  calm.apply(one);
  calm.reset();
  for (const float value : {0.2F, 0.9F}) {
    one.values.fill(value);
    two.values.fill(value);
    calm.apply(one);
    fresh.apply(two);
    EXPECT_EQ(one.values, two.values);
  }
}

}  // namespace
}  // namespace mien::tracker::jitter_filter_test
