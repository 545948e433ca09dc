#include "mien/eyewear/marker_network.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "mien/core/files.h"
#include "mien/eyewear/light_model.h"
#include "tests/eyewear/small_marker_network.h"
#include "tests/folder.h"
#include "tests/tracker/tiny_model.h"

namespace mien::eyewear::marker_network_test {
namespace {

using test::small_marker_network;

LightFrame light(std::vector<float> values, std::vector<std::uint8_t> present) {
  return {.values = std::move(values), .present = std::move(present)};
}

ErrorCode refusal(const MarkerNetworkFile& file) {
  const auto bytes = format_marker_network(file);
  return bytes ? ErrorCode::internal : bytes.error().code;
}

TEST(MarkerNetwork, IsReadBackAsItWasWritten) {
  const mien::test::Folder folder;
  const MarkerNetworkFile file = small_marker_network();
  ASSERT_TRUE(write_marker_network(folder / "glasses.safetensors", file));
  const auto back = read_marker_network(folder / "glasses.safetensors");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->architecture, file.architecture);
  EXPECT_EQ(back->sensors, file.sensors);
  EXPECT_EQ(back->markers, file.markers);
  EXPECT_EQ(back->scale_m, file.scale_m);
  EXPECT_EQ(back->rig, file.rig);
  EXPECT_EQ(back->recipe, file.recipe);
  EXPECT_EQ(back->results, file.results);
  EXPECT_EQ(back->network, file.network);
}

TEST(MarkerNetwork, RefusesWhatDoesNotHoldTogether) {
  MarkerNetworkFile file = small_marker_network();
  file.sensors.pop_back();
  EXPECT_EQ(refusal(file), ErrorCode::mismatch);
  file = small_marker_network();
  file.markers = {"brow", "brow"};
  EXPECT_EQ(refusal(file), ErrorCode::mismatch);
  file = small_marker_network();
  file.scale_m = 0;
  EXPECT_EQ(refusal(file), ErrorCode::out_of_range);
  file = small_marker_network();
  file.network.pop_back();
  EXPECT_EQ(refusal(file), ErrorCode::mismatch);
}

TEST(MarkerNetwork, ItsFaceRoundTripsToTheBitAndIsChecked) {
  MarkerNetworkFile file = small_marker_network();
  EXPECT_FALSE(parse_marker_network(*format_marker_network(file), "test")->face) << "older files have none";
  MarkedShapes face{Eigen::VectorXd::LinSpaced(6, -0.1, 1.0 / 3),
                    Eigen::MatrixXd::Zero(6, static_cast<Eigen::Index>(face::kShapeCount))};
  face.shapes_m.col(7) = Eigen::VectorXd::LinSpaced(6, 1e-9, std::numbers::pi / 100);
  file.face = face;
  const auto back = parse_marker_network(*format_marker_network(file), "test");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->face, file.face);
  file.face->neutral_m.conservativeResize(3);
  EXPECT_EQ(refusal(file), ErrorCode::mismatch);
  file.face = face;
  file.face->shapes_m.conservativeResize(6, 52);
  EXPECT_EQ(refusal(file), ErrorCode::mismatch);
  file.face = face;
  file.face->shapes_m(2, 7) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(refusal(file), ErrorCode::out_of_range);
  file.face->shapes_m(2, 7) = 1e200;
  EXPECT_EQ(refusal(file), ErrorCode::out_of_range);
}

TEST(MarkerNetwork, AModelAnswersOnTheFaceThatItWasTrainedFor) {
  MarkerNetworkFile file = small_marker_network();
  builtin_face::MarkerSet set{"two", {}};
  for (const std::string& name : file.markers)
    set.markers.push_back(
        {name, builtin_face::MarkerRegion::mouth, Vec3(0.01 * set.markers.size(), -0.03, 0.11)});
  const auto older = MarkedFace::of(file, set);
  ASSERT_TRUE(older) << older.error().message();
  MarkedShapes own = mark_builtin(set).value();
  EXPECT_EQ(older->neutral_m, own.neutral_m);
  own.neutral_m.array() += 0.5;
  file.face = own;
  EXPECT_EQ(MarkedFace::of(file, set)->neutral_m, own.neutral_m) << "whatever this program's face is";
  set.markers.pop_back();
  EXPECT_EQ(MarkedFace::of(file, set).error().code, ErrorCode::mismatch);
}

TEST(MarkerNetwork, ItsConfidenceTableRoundTripsAndIsChecked) {
  MarkerNetworkFile file = small_marker_network();
  EXPECT_FALSE(parse_marker_network(*format_marker_network(file), "test")->confidence);
  file.confidence = tracker::test::coverage_as_confidence();
  file.confidence->people = 7;
  file.confidence->seed = 2001;
  const auto back = parse_marker_network(*format_marker_network(file), "test");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->confidence, file.confidence);
  EXPECT_EQ(back->network, file.network);
  file.confidence->explained.pop_back();
  EXPECT_EQ(refusal(file), ErrorCode::mismatch);
}

TEST(MarkerNetwork, RefusesOtherFilesInOneLine) {
  const auto other = model::format_model(model::small_causal_model());
  ASSERT_TRUE(other);
  const auto as_eyewear = parse_marker_network(*other, "live.safetensors");
  ASSERT_FALSE(as_eyewear);
  EXPECT_EQ(as_eyewear.error().code, ErrorCode::unsupported);
  const auto mine = format_marker_network(small_marker_network());
  ASSERT_TRUE(mine);
  EXPECT_FALSE(model::parse_model(*mine, "eyewear.safetensors"));
  EXPECT_FALSE(parse_marker_network(std::span(*mine).first(mine->size() / 2), "cut"));
  EXPECT_FALSE(parse_marker_network({}, "nothing"));
}

TEST(NetworkRegressor, FindsSensorsByNameAndRemembers) {
  const MarkerNetworkFile file = small_marker_network();
  const auto in_order = NetworkRegressor::create(file, {"s0", "s1", "s2"});
  const auto turned = NetworkRegressor::create(file, {"s2", "other", "s1", "s0"});
  ASSERT_TRUE(in_order && turned);
  EXPECT_EQ((*in_order)->marker_count(), 2u);
  Eigen::VectorXd a, b, first;
  for (int i = 0; i < 5; ++i) {
    const float x = 0.3F * static_cast<float>(i);
    (*in_order)->step(light({x, 0.1F, -x}, {1, 1, 1}), a);
    (*turned)->step(light({-x, 9, 0.1F, x}, {1, 1, 1, 1}), b);
    EXPECT_EQ(a, b);
    if (i == 0) first = a;
  }
  ASSERT_EQ(a.size(), 6);
  (*in_order)->step(light({0, 0.1F, 0}, {1, 1, 1}), a);
  EXPECT_NE(a, first) << "the same light after another past";
  (*in_order)->reset();
  (*in_order)->step(light({0, 0.1F, 0}, {1, 1, 1}), a);
  EXPECT_EQ(a, first);
}

TEST(NetworkRegressor, CoversTheShareOfItsOwnSensorsThatIsThere) {
  MarkerNetworkFile file = small_marker_network();
  EXPECT_EQ(NetworkRegressor::create(file, {"s0"}).value()->confidence(), nullptr);
  file.confidence = tracker::test::coverage_as_confidence();
  // The rig has two of its three sensors, and one that it does not know.
  const auto regressor = NetworkRegressor::create(file, {"s2", "other", "s1"}).value();
  ASSERT_NE(regressor->confidence(), nullptr);
  EXPECT_EQ(*regressor->confidence(), *file.confidence);
  Eigen::VectorXd moved_m;
  regressor->step(light({0, 0, 0}, {1, 1, 1}), moved_m);
  EXPECT_FLOAT_EQ(regressor->coverage(), 2.0F / 3);
  regressor->step(light({0, 0, 0}, {0, 1, 1}), moved_m);
  EXPECT_FLOAT_EQ(regressor->coverage(), 1.0F / 3);
}

TEST(NetworkRegressor, TakesWhatIsMissingOrNotFiniteAsMissing) {
  const auto regressor = NetworkRegressor::create(small_marker_network(), {"s0", "s1", "s2"});
  ASSERT_TRUE(regressor);
  Eigen::VectorXd missing, sick;
  (*regressor)->step(light({0.5F, 7, 0.1F}, {1, 0, 1}), missing);
  (*regressor)->reset();
  (*regressor)->step(light({0.5F, std::numeric_limits<float>::quiet_NaN(), 0.1F}, {1, 1, 1}), sick);
  EXPECT_EQ(missing, sick);
  EXPECT_TRUE(missing.allFinite());
  EXPECT_FALSE(NetworkRegressor::create(small_marker_network(), {"elsewhere"}));
}

}  // namespace
}  // namespace mien::eyewear::marker_network_test
