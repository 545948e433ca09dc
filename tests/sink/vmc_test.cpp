#include "mien/sink/vmc.h"

#include <gtest/gtest.h>

#include <map>
#include <numeric>

#include "mien/core/random.h"
#include "tests/sink/osc_reading.h"

namespace mien::sink::vmc_test {
namespace {

std::vector<test::OscMessage> encoded(const face::OutputFrame& frame, const VmcOptions& options = {}) {
  Datagrams out;
  encode_vmc(arkit_frame(frame), frame.time, options, out);
  EXPECT_GE(out.size(), 2u);
  for (std::size_t i = 0; i < out.size(); ++i) EXPECT_LE(out[i].size(), 1500u);
  return test::osc_messages(out);
}

std::map<std::string, float> clips(const std::vector<test::OscMessage>& messages) {
  std::map<std::string, float> values;
  for (const auto& message : messages)
    if (message.address == "/VMC/Ext/Blend/Val")
      values[std::get<std::string>(message.arguments[0])] = std::get<float>(message.arguments[1]);
  return values;
}

Quat unity_bone(const std::vector<test::OscMessage>& messages, const std::string& bone) {
  for (const auto& message : messages) {
    if (message.address != "/VMC/Ext/Bone/Pos" || std::get<std::string>(message.arguments[0]) != bone)
      continue;
    const auto number = [&](std::size_t i) {
      return static_cast<double>(std::get<float>(message.arguments[i]));
    };
    EXPECT_EQ(number(1), 0);
    EXPECT_EQ(number(2), 0);
    EXPECT_EQ(number(3), 0);
    return Quat(number(7), number(4), number(5), number(6));
  }
  ADD_FAILURE() << "no bone " << bone;
  return Quat::Identity();
}

TEST(Vmc, SendsAllAndAppliesLast) {
  face::OutputFrame frame;
  frame.time = DeviceTime(std::chrono::milliseconds(2500));
  frame.weights[face::shape("jawOpen")] = 0.5F;
  frame.weights[face::shape("browInnerUp_L")] = 0.5F;
  frame.weights[face::shape("browInnerUp_R")] = 0.75F;
  frame.tongue_out = 0.125F;
  const auto messages = encoded(frame);
  EXPECT_EQ(messages.front().address, "/VMC/Ext/OK");
  EXPECT_EQ(std::get<int>(messages.front().arguments.at(0)), 1);
  EXPECT_EQ(messages.at(1).address, "/VMC/Ext/T");
  EXPECT_EQ(std::get<float>(messages.at(1).arguments.at(0)), 2.5F);
  EXPECT_EQ(messages.back(), (test::OscMessage{"/VMC/Ext/Blend/Apply", {}}));
  EXPECT_EQ(std::ranges::count(messages, "/VMC/Ext/Blend/Apply", &test::OscMessage::address), 1);

  const auto values = clips(messages);
  EXPECT_EQ(values.size(), 62u);
  EXPECT_EQ(values.at("JawOpen"), 0.5F);
  EXPECT_EQ(values.at("BrowInnerUp"), 0.625F);
  EXPECT_EQ(values.at("TongueOut"), 0.125F);
  EXPECT_EQ(values.at("A"), 0.75F);
  EXPECT_EQ(clips(encoded(frame, {.shapes = VmcShapes::perfect_sync})).size(), 52u);
  Datagrams out;
  encode_vmc(arkit_frame(frame), frame.time, {.shapes = VmcShapes::presets, .bones = false}, out);
  EXPECT_EQ(clips(test::osc_messages(out)).size(), kVmcPresets.size());
  EXPECT_EQ(test::osc_messages(out).size(), kVmcPresets.size() + 3);
}

/// Unity's avatar looks along +Z with +X to its own right and +Y up. Unity turns about Y to the right and
/// about X down, with positive angles: a left-handed system turns the other way round.
TEST(Vmc, TurnsBonesAsUnityDoes) {
  face::OutputFrame frame;
  frame.head = Quat(Eigen::AngleAxisd(0.3, Vec3::UnitY()));                // To the left.
  frame.eyes_rad = {Eigen::Vector2f(0, 0.2F), Eigen::Vector2f(-0.1F, 0)};  // Left eye up, right eye right.
  const auto messages = encoded(frame);
  // Quaternion multiplication is the same in both systems; only the meaning of the axes differs.
  const auto looks = [](const Quat& q) { return Vec3(q * Vec3::UnitZ()); };
  const Vec3 head = looks(unity_bone(messages, "Head"));
  EXPECT_NEAR(head.x(), -std::sin(0.3), 1e-6);
  EXPECT_NEAR(head.y(), 0, 1e-6);
  const Vec3 left = looks(unity_bone(messages, "LeftEye"));
  EXPECT_NEAR(left.x(), 0, 1e-6);
  EXPECT_NEAR(left.y(), std::sin(0.2), 1e-6);
  const Vec3 right = looks(unity_bone(messages, "RightEye"));
  EXPECT_NEAR(right.x(), std::sin(0.1), 1e-6);

  // A head that leans to its right shoulder carries its up axis to the right.
  frame.head = Quat(Eigen::AngleAxisd(0.4, Vec3::UnitZ()));
  const Quat leaning = unity_bone(encoded(frame), "Head");
  EXPECT_NEAR((leaning * Vec3::UnitY()).x(), std::sin(0.4), 1e-6);
  EXPECT_GE(leaning.w(), 0);
}

TEST(Vmc, DealsTheMouthOutBetweenTheVowels) {
  const auto of = [](std::initializer_list<std::pair<const char*, float>> weights) {
    ArkitFrame frame;
    for (const auto& [name, value] : weights) frame.weights.values[face::arkit_index(name)] = value;
    const auto values = vmc_presets(frame);
    std::map<std::string_view, float> named;
    for (std::size_t i = 0; i < values.size(); ++i) named[kVmcPresets[i]] = values[i];
    return named;
  };
  for (const auto& [name, value] : of({})) EXPECT_EQ(value, 0) << name;
  EXPECT_EQ(of({{"jawOpen", 1}}).at("A"), 1);
  // The jaw hangs and the lips are closed: nothing is said.
  EXPECT_EQ(of({{"jawOpen", 1}, {"mouthClose", 1}}).at("A"), 0);
  EXPECT_EQ(of({{"jawOpen", 1}, {"mouthFunnel", 1}}).at("O"), 1);
  EXPECT_EQ(of({{"jawOpen", 1}, {"mouthFunnel", 1}}).at("A"), 0);
  EXPECT_EQ(of({{"mouthPucker", 1}}).at("U"), 1);
  EXPECT_EQ(of({{"jawOpen", 1}, {"mouthStretchLeft", 1}, {"mouthStretchRight", 1}}).at("E"), 1);
  // A smile with closed lips is no vowel.
  const auto smile = of({{"mouthSmileLeft", 1}, {"mouthSmileRight", 1}});
  EXPECT_EQ(smile.at("I"), 0);
  EXPECT_EQ(smile.at("Joy"), 1);
  EXPECT_EQ(of({{"eyeBlinkLeft", 1}}).at("Blink_L"), 1);
  EXPECT_EQ(of({{"eyeBlinkLeft", 1}}).at("Blink_R"), 0);
}

TEST(Vmc, PresetsStayWithinBounds) {
  Random random(3);
  for (int round = 0; round < 2000; ++round) {
    face::OutputFrame frame;
    for (float& w : frame.weights.values) w = static_cast<float>(random.uniform() * 2 - 0.5);
    const auto values = vmc_presets(arkit_frame(frame));
    for (const float value : values) {
      EXPECT_GE(value, 0);
      EXPECT_LE(value, 1);
    }
    EXPECT_LE(std::accumulate(values.begin(), values.begin() + 5, 0.0F), 1.0001F);
  }
}

TEST(Vmc, AKnownPositionMovesTheWholeAvatar) {
  face::OutputFrame frame;
  EXPECT_EQ(std::ranges::count(encoded(frame), "/VMC/Ext/Root/Pos", &test::OscMessage::address), 0);
  frame.head_position_m = {0.25F, 0.5F, -1};  // To the performer's left, up, back.
  frame.head_position_known = true;
  const auto messages = encoded(frame);
  EXPECT_EQ(std::ranges::count(messages, "/VMC/Ext/Root/Pos", &test::OscMessage::address), 1);
  const auto root = std::ranges::find(messages, "/VMC/Ext/Root/Pos", &test::OscMessage::address);
  EXPECT_EQ(*root, (test::OscMessage{"/VMC/Ext/Root/Pos",
                                     {std::string("root"), -0.25F, 0.5F, -1.0F, 0.0F, 0.0F, 0.0F, 1.0F}}));
  unity_bone(messages, "Head");  // Whose own position stays 0.
  EXPECT_EQ(
      std::ranges::count(encoded(frame, {.bones = false}), "/VMC/Ext/Root/Pos", &test::OscMessage::address),
      0);
  frame.head_position_m = {std::nanf(""), 1e30F, -1e30F};
  const auto mended = encoded(frame);
  const auto at = std::ranges::find(mended, "/VMC/Ext/Root/Pos", &test::OscMessage::address);
  EXPECT_EQ(std::get<float>(at->arguments[1]), 0);
  EXPECT_EQ(std::get<float>(at->arguments[2]), kMostHead_m);
  EXPECT_EQ(std::get<float>(at->arguments[3]), -kMostHead_m);
}

}  // namespace
}  // namespace mien::sink::vmc_test
