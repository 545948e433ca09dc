#include "mien/sink/json_frame.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace mien::sink::json_frame_test {
namespace {

using Json = nlohmann::json;

TEST(JsonFrame, HelloNamesTheShapes) {
  const Json hello = Json::parse(hello_json({.software = "mien 1"}));
  EXPECT_EQ(hello.at("type"), "hello");
  EXPECT_EQ(hello.at("software"), "mien 1");
  ASSERT_EQ(hello.at("shapes").size(), face::kShapeCount);
  EXPECT_EQ(hello.at("shapes")[26], "jawOpen");
  EXPECT_EQ(hello.size(), 3u);
}

TEST(JsonFrame, HelloSaysAllOfTheSession) {
  Hello hello{.software = "mien 1"};
  hello.rig = {{.name = "default",
                .sensors = {{"ear", "imu", "behind_ear", "L", "head", std::nullopt},
                            {"brow", "imu", "frontalis", "R", "face", Vec3(0.5, -0.25, 1)}}}};
  hello.face = "/face.glb";
  hello.model = "causal";
  hello.mode = "replay";
  hello.listening = {{"udp://127.0.0.1:5005"}};
  EXPECT_EQ(Json::parse(hello_json(hello)).at("rig"), Json::parse(R"({"name": "default", "sensors": [
    {"name": "ear", "kind": "imu", "site": "behind_ear", "side": "L", "role": "head", "position_m": null},
    {"name": "brow", "kind": "imu", "site": "frontalis", "side": "R", "role": "face",
     "position_m": [0.5, -0.25, 1]}]})"));
  const Json json = Json::parse(hello_json(hello));
  EXPECT_EQ(json.at("face"), "/face.glb");
  EXPECT_EQ(json.at("model"), "causal");
  EXPECT_EQ(json.at("mode"), "replay");
  EXPECT_EQ(json.at("listening"), Json({"udp://127.0.0.1:5005"}));
  hello.model = "a \"name\"\n with \xff";
  EXPECT_FALSE(Json::parse(hello_json(hello)).empty());
}

TEST(JsonFrame, SaysAllOfAFrame) {
  face::OutputFrame frame;
  frame.time = DeviceTime(std::chrono::nanoseconds(123'456'789'012));
  frame.weights[0] = 0.5F;
  frame.weights[52] = 1.0F / 3;
  frame.confidence[1] = 0.25F;
  using face::Provenance;
  frame.provenance = {Provenance::measured, Provenance::interpolated, Provenance::predicted,
                      Provenance::held,     Provenance::audio,        Provenance::neutral};
  for (std::size_t i = 5; i < face::kShapeCount; ++i) frame.provenance[i] = Provenance::neutral;
  frame.tongue_out = 0.125F;
  frame.head = Quat(-0.5, 0.5, -0.5, 0.5);
  frame.head_confidence = 0.75F;
  frame.head_provenance = Provenance::measured;
  frame.eyes_rad = {Eigen::Vector2f(0.1F, -0.2F), Eigen::Vector2f(0.3F, 0)};
  frame.eyes_confidence = 1;
  frame.eyes_provenance = Provenance::audio;
  frame.region_confidence[2] = 0.875F;
  std::string text = "what stood there before";
  write_frame_json(frame, 7409, nullptr, text);
  const Json json = Json::parse(text);
  EXPECT_EQ(json.at("type"), "frame");
  EXPECT_EQ(json.at("index"), 7409);
  EXPECT_EQ(json.at("time"), 123.456789012);
  ASSERT_EQ(json.at("weights").size(), 53u);
  EXPECT_EQ(json.at("weights")[0], 0.5);
  EXPECT_EQ(json.at("weights")[1], 0);
  EXPECT_EQ(json.at("weights")[52], 0.33333);
  EXPECT_EQ(json.at("confidence")[1], 0.25);
  EXPECT_EQ(json.at("regions"), Json({0, 0, 0.875, 0, 0})) << "brows, eyes, cheeks, mouth, jaw";
  EXPECT_EQ(json.at("provenance"), "mipha" + std::string(48, 'n'));
  EXPECT_EQ(json.at("tongue_out"), 0.125);
  EXPECT_EQ(json.at("head"), Json({0.5, -0.5, 0.5, -0.5}));
  EXPECT_EQ(json.at("head_confidence"), 0.75);
  EXPECT_EQ(json.at("head_provenance"), "m");
  EXPECT_EQ(json.at("eyes"), Json({0.1, -0.2, 0.3, 0}));
  EXPECT_EQ(json.at("eyes_confidence"), 1);
  EXPECT_EQ(json.at("eyes_provenance"), "a");
  EXPECT_FALSE(json.contains("truth"));
  EXPECT_EQ(json.size(), 14u);

  face::BlendshapeWeights truth;
  truth[3] = 0.5F;
  write_frame_json(frame, 0, &truth, text);
  EXPECT_EQ(Json::parse(text).at("truth")[3], 0.5);
}

TEST(JsonFrame, StaysJsonWhateverIsInTheFrame) {
  face::OutputFrame frame;
  frame.time = DeviceTime(std::chrono::nanoseconds(-1'500'000'000));
  frame.weights.values.fill(std::numeric_limits<float>::quiet_NaN());
  frame.weights[1] = 1e-30F;
  frame.weights[2] = -0.0F;
  frame.eyes_rad[0].setConstant(std::numeric_limits<float>::infinity());
  frame.head.coeffs().setConstant(std::numeric_limits<double>::quiet_NaN());
  std::string text;
  write_frame_json(frame, -90, nullptr, text);
  const Json json = Json::parse(text);
  EXPECT_EQ(json.at("time"), -1.5);
  EXPECT_EQ(json.at("weights")[0], 0);
  EXPECT_EQ(json.at("head"), Json({1, 0, 0, 0}));
  EXPECT_EQ(json.at("eyes")[0], 0);
  // The storage is reused.
  const char* const storage = text.data();
  write_frame_json({}, 1, nullptr, text);
  EXPECT_EQ(text.data(), storage);
}

TEST(JsonFrame, SaysAPositionWhereItIsKnown) {
  face::OutputFrame frame;
  frame.head_position_m = {0.25F, -1.0F / 3, 0};
  std::string text;
  write_frame_json(frame, 0, nullptr, text);
  EXPECT_FALSE(Json::parse(text).contains("head_position_m"));
  frame.head_position_known = true;
  write_frame_json(frame, 0, nullptr, text);
  EXPECT_EQ(Json::parse(text).at("head_position_m"), Json({0.25, -0.33333, 0}));
  frame.head_position_m[1] = std::numeric_limits<float>::quiet_NaN();
  write_frame_json(frame, 0, nullptr, text);
  EXPECT_EQ(Json::parse(text).at("head_position_m"), Json({0.25, 0, 0}));
}

}  // namespace
}  // namespace mien::sink::json_frame_test
