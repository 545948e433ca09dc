#include "mien/builtin_face/markers.h"

#include <gtest/gtest.h>

#include <string>

#include "mien/builtin_face/builtin_face.h"
#include "tests/project_path.h"

namespace mien::builtin_face::markers_test {
namespace {

const std::string kTwo = R"(name = "two"
[[marker]]
name = "tip"
region = "eyes_nose"
position_m = [0, 0.004, 0.1295]
[[marker]]
name = "chin"
region = "mouth"
position_m = [0, -0.066, 0.1088]
)";

TEST(Markers, ThePublishedSetIsThere) {
  const auto set = read_markers(project_path("rigs/markers.toml"));
  ASSERT_TRUE(set) << set.error().message();
  EXPECT_EQ(set->markers.size(), 37u);
  EXPECT_EQ(set->of(MarkerRegion::eyes_nose).size(), 22u);
  EXPECT_EQ(set->of(MarkerRegion::mouth).size(), 15u);
  for (std::size_t i = 31; i < 34; ++i) EXPECT_TRUE(set->markers[i].name.starts_with("lip_lower")) << i + 1;
  for (std::size_t i = 34; i < 37; ++i) EXPECT_TRUE(set->markers[i].name.starts_with("chin")) << i + 1;
}

TEST(Markers, StickToTheSkinOfEveryHead) {
  const auto set = read_markers(project_path("rigs/markers.toml"));
  ASSERT_TRUE(set);
  const auto home = PlacedMarkers::place(builtin_face::make_builtin(), *set);
  const auto other =
      PlacedMarkers::place(builtin_face::make_builtin({.face_length = 2, .nose_length = 1}), *set);
  ASSERT_TRUE(home && other);
  double moved = 0;
  for (std::size_t i = 0; i < home->count(); ++i) {
    EXPECT_LT((home->neutral_m()[i] - set->markers[i].position_m).norm(), 0.003) << set->markers[i].name;
    moved += (home->neutral_m()[i] - other->neutral_m()[i]).norm();
  }
  EXPECT_GT(moved / static_cast<double>(home->count()), 0.0005);
}

TEST(Markers, MoveWithTheFace) {
  const auto set = parse_markers(kTwo, "two");
  ASSERT_TRUE(set) << set.error().message();
  const auto placed = PlacedMarkers::place(builtin_face::make_builtin(), *set);
  ASSERT_TRUE(placed);
  face::BlendshapeWeights weights;
  const Eigen::VectorXd rest = placed->at(weights);
  ASSERT_EQ(rest.size(), 6);
  EXPECT_EQ(Vec3(rest.head<3>()), placed->neutral_m()[0]);
  weights[face::shape("jawOpen")] = 0.5F;
  const Eigen::VectorXd half = placed->at(weights);
  weights[face::shape("jawOpen")] = 1;
  const Eigen::VectorXd open = placed->at(weights);
  EXPECT_LT((open.head<3>() - rest.head<3>()).norm(), 0.001);
  EXPECT_LT(open[4] - rest[4], -0.02);
  EXPECT_LT(((open - rest) - 2 * (half - rest)).norm(), 1e-9);
}

TEST(Markers, NeedAFaceWithLandmarks) {
  const auto set = parse_markers(kTwo, "two");
  ASSERT_TRUE(set);
  face::Face face = builtin_face::make_builtin();
  face.origin = face::Origin::other;
  EXPECT_TRUE(PlacedMarkers::place(face, *set));
  face.has_landmarks = false;
  EXPECT_EQ(PlacedMarkers::place(face, *set).error().code, ErrorCode::not_found);
}

struct Wrong {
  const char* from;
  const char* to;
  ErrorCode code;
};
class WrongMarkers : public testing::TestWithParam<Wrong> {};

TEST_P(WrongMarkers, AreRefusedWithOneLine) {
  std::string text = kTwo;
  const auto at = text.find(GetParam().from);
  ASSERT_NE(at, std::string::npos);
  const auto set =
      parse_markers(text.replace(at, std::string(GetParam().from).size(), GetParam().to), "w.toml");
  ASSERT_FALSE(set);
  EXPECT_EQ(set.error().code, GetParam().code) << set.error().message();
  EXPECT_NE(set.error().where.find("w.toml"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Markers, WrongMarkers,
    testing::Values(Wrong{"name = \"two\"", "", ErrorCode::malformed},
                    Wrong{"name = \"two\"", "name = \"two\"\nkind = 1", ErrorCode::malformed},
                    Wrong{"name = \"tip\"", "name = \"\"", ErrorCode::malformed},
                    Wrong{"name = \"tip\"", "name = \"chin\"", ErrorCode::malformed},
                    Wrong{"name = \"tip\"", "name = \"tip\"\ncolour = 1", ErrorCode::malformed},
                    Wrong{"\"eyes_nose\"", "\"ear\"", ErrorCode::malformed},
                    Wrong{"[0, 0.004, 0.1295]", "[0, 0.004]", ErrorCode::malformed},
                    Wrong{"[0, 0.004, 0.1295]", "[0, true, 0.1]", ErrorCode::malformed},
                    Wrong{"[0, 0.004, 0.1295]", "[0, nan, 0.1]", ErrorCode::out_of_range},
                    Wrong{"[0, 0.004, 0.1295]", "[0, 40, 1295]", ErrorCode::out_of_range}));

TEST(Markers, RefuseNoneAndTooMany) {
  EXPECT_FALSE(parse_markers("name = \"none\"\n", "t"));
  EXPECT_FALSE(parse_markers("name = \"none\"\nmarker = []\n", "t"));
  EXPECT_FALSE(parse_markers("[", "t"));
  std::string many = "name = \"many\"\n";
  for (int i = 0; i < 257; ++i)
    many += "[[marker]]\nname = \"m" + std::to_string(i) + "\"\nregion = \"mouth\"\nposition_m = [0, 0, 0]\n";
  EXPECT_EQ(parse_markers(many, "t").error().code, ErrorCode::out_of_range);
}

}  // namespace
}  // namespace mien::builtin_face::markers_test
