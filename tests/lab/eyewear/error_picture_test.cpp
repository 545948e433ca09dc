#include "lab/eyewear/error_picture.h"
#include "tests/project_path.h"

#include <gtest/gtest.h>

#include <array>

namespace mien::lab::error_picture_test {
namespace {

TEST(ErrorPicture, IsDarkerWhereTheErrorIsLarge) {
  const builtin_face::MarkerSet markers =
      builtin_face::read_markers(project_path("rigs/markers.toml")).value();
  SensorsMethod small, large;
  small.name = "small";
  large.name = "large";
  small.markers.assign(markers.markers.size(), {0, 0});
  large.markers.assign(markers.markers.size(), {8, 8});
  const std::array<const SensorsMethod*, 2> both = {&small, &large};
  const auto picture = error_picture(markers, both, 8, 96);
  ASSERT_TRUE(picture) << picture.error().message();
  ASSERT_EQ(picture->width, 192);
  const auto light = [&](int from) {
    long sum = 0;
    for (int y = 30; y < 70; ++y)
      for (int x = from + 30; x < from + 70; ++x) sum += picture->pixel(x, y)[1];
    return sum;
  };
  EXPECT_LT(light(96), 0.8 * static_cast<double>(light(0)));
  small.markers.pop_back();
  EXPECT_FALSE(error_picture(markers, both, 8, 96));
}

}  // namespace
}  // namespace mien::lab::error_picture_test
