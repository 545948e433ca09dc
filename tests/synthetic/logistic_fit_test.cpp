#include "mien/synthetic/logistic_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/core/random.h"

namespace mien::synthetic::logistic_fit_test {
namespace {

TEST(LogisticMap, IsOneOverOnePlusExp) {
  EXPECT_EQ((model::LogisticMap{0, 0}.at(5)), 0.5F);
  EXPECT_FLOAT_EQ((model::LogisticMap{0, 1}.at(std::log(3.0F))), 0.75F);
  EXPECT_FLOAT_EQ((model::LogisticMap{-1, 2}.at(0.5F)), 0.5F);
  EXPECT_FLOAT_EQ((model::LogisticMap{1, -1}.at(1 + std::log(4.0F))), 0.2F);
  EXPECT_EQ((model::LogisticMap{0, 1e6F}.at(1000)), 1.0F) << "no overflow";
  EXPECT_EQ((model::LogisticMap{0, 1e6F}.at(-1000)), 0.0F);
}

TEST(LogisticFit, TwoScoresAreMetExactly) {
  // With two scores the likelihood is largest where both shares are met: 0.25 at -1, 0.75 at 2, so the
  // log-odds rise from -ln 3 to ln 3 over 3.
  LogisticFit fit;
  for (int i = 0; i < 4000; ++i) {
    fit.add(-1, i % 4 == 0);
    fit.add(2, i % 4 != 0);
  }
  const model::LogisticMap map = fit.solve();
  EXPECT_NEAR(map.slope, 2 * std::log(3.0) / 3, 1e-4);
  EXPECT_NEAR(map.offset, -std::log(3.0) / 3, 1e-4);
}

TEST(LogisticFit, FindsTheParametersThatMadeTheData) {
  for (const model::LogisticMap truth : {model::LogisticMap{-0.7F, 1.8F}, {2, -0.5F}, {0.3F, 0}}) {
    Random random(4);
    LogisticFit whole, halves[2];
    for (int i = 0; i < 200'000; ++i) {
      const auto score = static_cast<float>(random.normal(0.5, 1.5));
      const bool hit = random.chance(static_cast<double>(truth.at(score)));
      whole.add(score, hit);
      halves[i % 2].add(score, hit);
    }
    const model::LogisticMap found = whole.solve();
    // Four standard errors of so many.
    EXPECT_NEAR(found.offset, truth.offset, 0.05);
    EXPECT_NEAR(found.slope, truth.slope, 0.03);
    halves[0].add(halves[1]);
    EXPECT_EQ(halves[0].frames(), 200'000);
    EXPECT_NEAR(halves[0].solve().offset, found.offset, 1e-5) << "parts add up";
  }
}

TEST(LogisticFit, StaysFiniteWhateverItSees) {
  EXPECT_EQ(LogisticFit().solve(), model::LogisticMap());
  for (const bool hit : {false, true}) {
    LogisticFit fit;
    for (int i = 0; i < 1000; ++i) fit.add(static_cast<float>(i % 7) * 1e6F, hit);
    const model::LogisticMap map = fit.solve();
    EXPECT_LT(std::abs(map.offset), 100);
    EXPECT_LT(std::abs(map.slope), 100);
    EXPECT_EQ(map.at(1) > 0.5F, hit);
  }
  LogisticFit split;  // A score that tells all.
  for (int i = 0; i < 1000; ++i) split.add(i % 2 == 0 ? -1 : 1, i % 2 != 0);
  EXPECT_GT(split.solve().at(1), 0.99F);
  EXPECT_LT(split.solve().slope, 100);
}

}  // namespace
}  // namespace mien::synthetic::logistic_fit_test
