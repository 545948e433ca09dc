#include "mien/model/ridge.h"

#include <gtest/gtest.h>

#include "mien/core/random.h"

namespace mien::model::ridge_test {
namespace {

/// Two weights linear in three features, and a feature that never changes.
struct Line {
  std::vector<float> condition, weights;
  Line(std::size_t frames, double noise, std::uint64_t seed) {
    Random random(seed);
    for (std::size_t f = 0; f < frames; ++f) {
      const double a = random.normal(), b = random.normal(), c = random.normal();
      for (const double v : {a, b, c, 1.0}) condition.push_back(static_cast<float>(v));
      weights.push_back(static_cast<float>(0.5 + 0.05 * a - 0.02 * b + noise * random.normal()));
      weights.push_back(static_cast<float>(0.3 + 0.04 * c + noise * random.normal()));
    }
  }
};

TEST(Ridge, FindsALineExactly) {
  const Line line(500, 0, 1);
  RidgeFit fit(4, 2);
  fit.add(std::span(line.condition).first(4 * 123), std::span(line.weights).first(2 * 123));
  fit.add(std::span(line.condition).subspan(4 * 123), std::span(line.weights).subspan(2 * 123));
  EXPECT_EQ(fit.frames(), 500U);
  const auto ridge = fit.solve(0);
  ASSERT_TRUE(ridge);
  EXPECT_LT(mean_squared_error(*ridge, line.condition, line.weights), 1e-10);
  std::vector<float> out(2);
  ridge->predict(std::vector<float>{1, 1, 1, 1}, out);
  EXPECT_NEAR(out[0], 0.53, 1e-4);
  EXPECT_NEAR(out[1], 0.34, 1e-4);
  ridge->predict(std::vector<float>{100, 0, 0, 1}, out);
  EXPECT_EQ(out[0], 1.0F) << "held to a weight's range";
}

TEST(Ridge, APenaltyPullsTowardsTheMean) {
  const Line line(500, 0, 1);
  RidgeFit fit(4, 2);
  fit.add(line.condition, line.weights);
  const auto ridge = fit.solve(1e6);
  ASSERT_TRUE(ridge);
  std::vector<float> out(2);
  ridge->predict(std::vector<float>{3, -3, 3, 1}, out);
  EXPECT_NEAR(out[0], 0.5, 0.01);
  EXPECT_NEAR(out[1], 0.3, 0.01);
}

TEST(Ridge, ThePenaltyIsTheOneThatValidatesBest) {
  const Line train(12, 0.2, 2), validation(2000, 0.2, 3);
  RidgeFit fit(4, 2);
  fit.add(train.condition, train.weights);
  const auto best = choose_ridge(fit, validation.condition, validation.weights);
  ASSERT_TRUE(best);
  for (const double penalty : {1e-6, 1e-3, 0.1, 1.0, 10.0})
    EXPECT_LE(best->validation_mse,
              mean_squared_error(*fit.solve(penalty), validation.condition, validation.weights));
  EXPECT_GT(best->penalty, 1e-3) << "few noisy frames want a penalty";
}

TEST(Ridge, WithoutFramesThereIsNone) {
  EXPECT_FALSE(RidgeFit(4, 2).solve(1));
}

}  // namespace
}  // namespace mien::model::ridge_test
