#include "mien/tracker/calm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mien/core/random.h"

namespace mien::tracker {
namespace {

TEST(Calm, TakesTremblingOutAndFollowsABlink) {
  Calm calm;
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
    weights[0] = tremble;
    weights[1] = lid;
    calm.apply(weights);
    std::rotate(in.begin(), in.begin() + 1, in.end());
    std::rotate(out.begin(), out.begin() + 1, out.end());
    in[3] = tremble;
    out[3] = weights[0];
    if (f > 60) trembling += third(in), left += third(out);
    if (f == 312) largest_lag = 1 - weights[1];
    EXPECT_EQ(weights[2], 0);
  }
  EXPECT_LT(left, 0.3 * trembling);
  EXPECT_LT(largest_lag, 0.2) << "a tenth of a second after it has closed";
}

TEST(Calm, ForgetsAtAReset) {
  Calm calm, fresh;
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
}  // namespace mien::tracker
