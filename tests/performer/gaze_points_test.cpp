#include "mien/performer/gaze_points.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/core/time.h"
#include "mien/face/face.h"

namespace mien::performer::gaze_points_test {
namespace {

constexpr double kEach_s = 2;

std::vector<Eigen::Vector2f> eyes(std::uint64_t seed) {
  std::vector<Eigen::Vector2f> out;
  for (const auto& weights : look_at_targets(face::gaze_targets(), kEach_s, Random(seed)))
    out.push_back(face::eyes_rad(weights)[0]);
  return out;
}

TEST(GazePoints, TheEyesTurnLateAndComeToRestNearEachTarget) {
  double off = 0, count = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto looks = eyes(seed);
    ASSERT_EQ(looks.size(), 600u);
    for (std::size_t t = 0; t < 5; ++t) {
      const Eigen::Vector2f target = face::gaze_targets()[t].direction_rad;
      const auto begin = t * 120;
      if (t > 0) {
        EXPECT_GT((looks[begin + 10] - target).norm(), 0.1F) << "not before it was understood";
      }
      for (std::size_t i = begin + 40; i < begin + 120; ++i) {
        EXPECT_LT((looks[i] - target).norm(), 0.06F);
        off += static_cast<double>((looks[i] - target).squaredNorm());
        ++count;
      }
    }
  }
  EXPECT_NEAR(std::sqrt(off / count / 2) * 57.3, 0.5, 0.15) << "degrees, an axis";
}

TEST(GazePoints, LidsBlinkAndNothingElseMoves) {
  std::size_t shut = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    for (const auto& weights : look_at_targets(face::gaze_targets(), kEach_s, Random(seed))) {
      if (weights[face::shape("eyeBlink_L")] > 0.8F) ++shut;
      EXPECT_EQ(weights[face::shape("jawOpen")], 0);
      for (const float weight : weights.values) {
        EXPECT_GE(weight, 0);
        EXPECT_LE(weight, 1);
      }
    }
  EXPECT_GT(shut, 20u);
}

TEST(GazePoints, AreTheSameForASeed) {
  EXPECT_EQ(eyes(3), eyes(3));
  EXPECT_NE(eyes(3), eyes(4));
  EXPECT_TRUE(look_at_targets({}, kEach_s, Random(1)).empty());
}

}  // namespace
}  // namespace mien::performer::gaze_points_test
