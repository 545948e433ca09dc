#include "mien/face/target_names.h"

#include <gtest/gtest.h>

#include <vector>

#include "mien/face/profile.h"

namespace mien::face::target_names_test {
namespace {

TEST(ShapesNamed, OneOrBothSidesOrNone) {
  using Shapes = std::vector<std::size_t>;
  EXPECT_EQ(shapes_named("jawOpen"), Shapes{shape("jawOpen")});
  EXPECT_EQ(shapes_named("mouthSmile_R"), Shapes{shape("mouthSmile_R")});
  EXPECT_EQ(shapes_named("mouthSmile"), (Shapes{shape("mouthSmile_L"), shape("mouthSmile_R")}));
  for (const char* none : {"", "smile", "mouthSmil", "jawOpen_L", "mouthSmile_"})
    EXPECT_TRUE(shapes_named(none).empty()) << none;
}

}  // namespace
}  // namespace mien::face::target_names_test
