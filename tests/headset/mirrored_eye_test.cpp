#include "mien/headset/mirrored_eye.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/core/random.h"

namespace mien::headset::mirrored_eye_test {
namespace {

using Eyes = std::vector<std::vector<float>>;

/// Features of which the first says which kind it is, beside others that vary with it and by themselves.
Eyes eyes(double kind, std::size_t count, Random random) {
  Eyes all;
  for (std::size_t i = 0; i < count; ++i) {
    const double common = random.normal(0, 3);
    all.push_back({static_cast<float>(kind + common), static_cast<float>(common + 0.1 * random.normal()),
                   static_cast<float>(random.normal())});
  }
  return all;
}

TEST(MirroredEye, IsToldByWhatDiffersAndNotByWhatVaries) {
  const Eyes seen = eyes(0, 200, Random(1)), mirrored = eyes(1, 200, Random(2));
  const auto fitted = fit_mirrored_eye(seen, mirrored);
  ASSERT_TRUE(fitted) << fitted.error().message();
  std::size_t right = 0;
  for (const auto& eye : eyes(0, 100, Random(3))) right += fitted->logit(eye) < 0 ? 1 : 0;
  for (const auto& eye : eyes(1, 100, Random(4))) right += fitted->logit(eye) > 0 ? 1 : 0;
  // The kinds are a third of what each feature varies by apart, and what is common to two of them is taken
  // off.
  EXPECT_GT(right, 190U);
  // In the middle between the two it is as likely as not.
  EXPECT_NEAR(fitted->logit(std::vector<float>{0.5F, 0, 0}), 0, 1.5);
}

TEST(MirroredEye, TellsNothingWhereNothingIsKnown) {
  EXPECT_EQ(MirroredEye().logit(std::vector<float>{1, 2}), 0);
  EXPECT_EQ((MirroredEye{.weight = {1}, .bias = 1}.logit(std::vector<float>{1, 2})), 0);
}

TEST(MirroredEye, RefusesTooFewAndOthers) {
  const Eyes two = {{1, 2}, {3, 4}}, one = {{1, 2}}, other = {{1}, {2}}, none = {{}, {}};
  EXPECT_TRUE(fit_mirrored_eye(two, two));
  EXPECT_FALSE(fit_mirrored_eye(one, two));
  EXPECT_FALSE(fit_mirrored_eye(two, {}));
  EXPECT_FALSE(fit_mirrored_eye(two, other));
  EXPECT_FALSE(fit_mirrored_eye(none, none));
  // Alike in all: no number that is none.
  const auto same = fit_mirrored_eye(Eyes{{1, 1}, {1, 1}}, Eyes{{1, 1}, {1, 1}});
  ASSERT_TRUE(same);
  EXPECT_TRUE(std::isfinite(same->logit(std::vector<float>{1, 1})));
}

}  // namespace
}  // namespace mien::headset::mirrored_eye_test
