#include "mien/virtual/eyewear/marker_poses.h"
#include "tests/project_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace mien::virt::marker_poses_test {
namespace {

const builtin_face::MarkerSet& markers() {
  static const builtin_face::MarkerSet set =
      builtin_face::read_markers(project_path("rigs/markers.toml")).value();
  return set;
}

TEST(MarkerPoses, SixComponentsHoldMostOfTheMotion) {
  const auto poses = MarkerPoses::measure(markers(), 30, Random(1));
  ASSERT_TRUE(poses) << poses.error().message();
  EXPECT_GT(poses->share(), 0.6);
  EXPECT_LT(poses->share(), 1);
  std::array<Level, kPoseComponents> least, origin, most;
  least.fill(Level::least);
  origin.fill(Level::origin);
  most.fill(Level::most);
  EXPECT_NE(poses->pose(least), poses->pose(most));
  for (const auto& levels : {least, origin, most})
    for (const float weight : poses->pose(levels).values) {
      EXPECT_GE(weight, 0);
      EXPECT_LE(weight, 1);
    }
  float moved = 0;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    moved = std::max(moved, std::abs(poses->pose(most)[k] - poses->pose(origin)[k]));
  EXPECT_GT(moved, 0.2F) << "the extremes of a component are expressions, not twitches";
}

TEST(MarkerPoses, NeedsSomethingToMeasure) {
  EXPECT_EQ(MarkerPoses::measure(markers(), 1, Random(1)).error().code, ErrorCode::bad_usage);
}

}  // namespace
}  // namespace mien::virt::marker_poses_test
