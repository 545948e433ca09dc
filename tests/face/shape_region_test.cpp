#include "mien/face/shape_region.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace mien::face::shape_region_test {
namespace {

TEST(ShapeRegion, EveryShapeStandsWhereItActs) {
  const auto region = [](std::string_view name) { return kShapeRegions[shape_index(name)]; };
  EXPECT_EQ(region("browInnerUp_L"), ShapeRegion::brows);
  EXPECT_EQ(region("eyeBlink_R"), ShapeRegion::eyes);
  EXPECT_EQ(region("eyeLookIn_L"), ShapeRegion::eyes);
  EXPECT_EQ(region("cheekPuff_L"), ShapeRegion::cheeks);
  EXPECT_EQ(region("noseSneer_R"), ShapeRegion::cheeks);
  EXPECT_EQ(region("mouthClose"), ShapeRegion::mouth);
  EXPECT_EQ(region("jawOpen"), ShapeRegion::jaw);
  EXPECT_EQ(std::ranges::count(kShapeRegions, ShapeRegion::brows), 6);
  EXPECT_EQ(std::ranges::count(kShapeRegions, ShapeRegion::eyes), 14);
  EXPECT_EQ(std::ranges::count(kShapeRegions, ShapeRegion::cheeks), 6);
  EXPECT_EQ(std::ranges::count(kShapeRegions, ShapeRegion::mouth), 23);
  EXPECT_EQ(std::ranges::count(kShapeRegions, ShapeRegion::jaw), 4);
}

}  // namespace
}  // namespace mien::face::shape_region_test
