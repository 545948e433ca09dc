#include "mien/tracker/jitter_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

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

TEST(JitterFilter, AMovementIsHardlyLate) {
  JitterFilter calm;
  float late = 0;
  for (int f = 0; f < 120; ++f) {
    face::BlendshapeWeights weights;
    const float truth = std::clamp(static_cast<float>(f - 60) / 60, 0.0F, 1.0F);
    weights[kMouth] = truth;
    calm.apply(weights);
    late = std::max(late, truth - weights[kMouth]);
    if (f > 60 + 45) {
      EXPECT_LT(truth - weights[kMouth], 0.03F) << f << ": both filters delay by 0.06 together";
    }
    EXPECT_LE(weights[kMouth], 1);
  }
  EXPECT_LT(late, 0.09F) << "when it begins";
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
