#include "mien/sink/vrchat.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <numbers>

#include "mien/sink/osc_bundles.h"
#include "tests/sink/osc_reading.h"

namespace mien::sink::vrchat_test {
namespace {

using Type = VrchatAvatar::Type;
using Messages = std::map<std::string, std::vector<test::OscArgument>>;

Messages encoded(VrchatEncoder& encoder, const face::OutputFrame& frame, std::int64_t index) {
  Datagrams out;
  encoder.encode(arkit_frame(frame), index, out);
  for (std::size_t i = 0; i < out.size(); ++i) EXPECT_LE(out[i].size(), OscBundles::kMaxBytes);
  Messages messages;
  for (auto& message : test::osc_messages(out))
    EXPECT_TRUE(messages.emplace(message.address, message.arguments).second) << message.address;
  return messages;
}

std::string parameter(const std::string& name) {
  return "/avatar/parameters/" + name;
}

face::OutputFrame jaw(float open) {
  face::OutputFrame frame;
  frame.provenance.fill(face::Provenance::neutral);
  frame.weights[face::shape("jawOpen")] = open;
  return frame;
}

/// What VRChat checks.
TEST(Vrchat, CutsFloatsIntoBits) {
  const auto bits = [](float value, int count, bool negative) {
    unsigned set = 0;
    for (int bit = 0; bit < count; ++bit)
      if (binary_bit(value, bit, count, negative)) set |= 1U << bit;
    return set;
  };
  EXPECT_EQ(bits(0.5F, 3, true), 4u);
  EXPECT_EQ(bits(0.3F, 4, true), 4u);
  EXPECT_EQ(bits(1.0F, 3, true), 7u);
  EXPECT_EQ(bits(1.0F, 7, false), 127u);
  EXPECT_EQ(bits(-0.6F, 3, true), 4u);
  EXPECT_EQ(bits(-0.6F, 3, false), 0u);
  EXPECT_EQ(bits(0.0F, 7, true), 0u);
  for (int step = 0; step < 128; ++step) EXPECT_EQ(bits(static_cast<float>(step) / 128, 7, true), step);
}

TEST(Vrchat, SendsAllThenWhatChangesThenAllAgain) {
  auto encoder = VrchatEncoder::make({});
  ASSERT_TRUE(encoder);
  const auto first = encoded(*encoder, jaw(0.25F), 0);
  // Eyes and lids that nobody looks at are left to VRChat: six directions, and its own of both.
  EXPECT_EQ(first.size(), encoder->size() - 8);
  EXPECT_EQ(std::get<float>(first.at(parameter("v2/JawOpen"))[0]), 0.25F);
  EXPECT_EQ(std::get<bool>(first.at(parameter("EyeTrackingActive"))[0]), false);
  EXPECT_EQ(std::get<bool>(first.at(parameter("LipTrackingActive"))[0]), false);

  EXPECT_TRUE(encoded(*encoder, jaw(0.25F), 1).empty());
  EXPECT_TRUE(encoded(*encoder, jaw(0.2509F), 2).empty());
  const auto changed = encoded(*encoder, jaw(0.2511F), 3);
  EXPECT_EQ(changed.size(), 1u);
  EXPECT_EQ(std::get<float>(changed.at(parameter("v2/JawOpen"))[0]), 0.2511F);
  EXPECT_TRUE(encoded(*encoder, jaw(0.2511F), 59).empty());
  EXPECT_EQ(encoded(*encoder, jaw(0.2511F), 60).size(), first.size());
  EXPECT_TRUE(encoded(*encoder, jaw(0.2511F), 61).empty());
  EXPECT_EQ(encoded(*encoder, jaw(0.2511F), 3).size(), first.size());  // A replay was set back.
}

/// Slow changes must not be lost below the threshold.
TEST(Vrchat, FollowsASlowChange) {
  auto encoder = VrchatEncoder::make({});
  ASSERT_TRUE(encoder);
  (void)encoded(*encoder, jaw(0), 0);
  int sent = 0;
  for (int i = 1; i <= 50; ++i)
    sent += encoded(*encoder, jaw(0.0004F * static_cast<float>(i)), i).empty() ? 0 : 1;
  EXPECT_EQ(sent, 16);
}

TEST(Vrchat, TurnsTheEyesInDegrees) {
  auto encoder = VrchatEncoder::make({});
  ASSERT_TRUE(encoder);
  face::OutputFrame frame = jaw(0);
  frame.eyes_provenance = face::Provenance::measured;
  // The left eye 10 degrees left and 5 up, the right eye 20 right and 10 down.
  const float degree = std::numbers::pi_v<float> / 180;
  frame.eyes_rad = {Eigen::Vector2f(10, 5) * degree, Eigen::Vector2f(-20, -10) * degree};
  frame.weights[face::shape("eyeBlink_L")] = 1;
  frame.provenance[face::shape("eyeBlink_L")] = face::Provenance::measured;
  const auto messages = encoded(*encoder, frame, 0);
  const auto& eyes = messages.at("/tracking/eye/LeftRightPitchYaw");
  ASSERT_EQ(eyes.size(), 4u);
  EXPECT_NEAR(std::get<float>(eyes[0]), -5, 1e-4);
  EXPECT_NEAR(std::get<float>(eyes[1]), -10, 1e-4);
  EXPECT_NEAR(std::get<float>(eyes[2]), 10, 1e-4);
  EXPECT_NEAR(std::get<float>(eyes[3]), 20, 1e-4);
  EXPECT_EQ(std::get<float>(messages.at("/tracking/eye/EyesClosedAmount")[0]), 0.5F);
  EXPECT_EQ(std::get<bool>(messages.at(parameter("EyeTrackingActive"))[0]), true);
  EXPECT_EQ(std::get<bool>(messages.at(parameter("ExpressionTrackingActive"))[0]), true);

  auto without = VrchatEncoder::make({.native_eyes = false});
  ASSERT_TRUE(without);
  for (const auto& [address, arguments] : encoded(*without, frame, 0))
    EXPECT_FALSE(address.starts_with("/tracking"));
}

/// Does the message say where the eyes look?
bool of_gaze(const std::string& address) {
  const std::string_view name = std::string_view(address).substr(address.rfind('/') + 1);
  return address == "/tracking/eye/LeftRightPitchYaw" || name.starts_with("EyeX") ||
         name.starts_with("EyeY") || name.starts_with("EyeLeftX") || name.starts_with("EyeLeftY") ||
         name.starts_with("EyeRightX") || name.starts_with("EyeRightY");
}

TEST(Vrchat, SendsGazeOnlyWhileSomethingLooksAtTheEyes) {
  using enum face::Provenance;
  for (const face::Provenance p : {measured, interpolated, predicted, held, audio, neutral}) {
    auto encoder = VrchatEncoder::make({.prefix = "FT/", .binary_bits = 2});
    ASSERT_TRUE(encoder);
    face::OutputFrame frame = jaw(0.5F);
    frame.provenance.fill(measured);
    frame.eyes_rad = {Eigen::Vector2f(0.2F, 0.1F), Eigen::Vector2f(0.2F, 0.1F)};
    frame.eyes_provenance = p;
    const bool looks = p == measured || p == interpolated;
    int gaze = 0;
    for (std::int64_t i = 0; i < 180; ++i) {
      frame.eyes_rad[0].x() = 0.001F * static_cast<float>(i);
      const auto messages = encoded(*encoder, frame, i);
      for (const auto& [address, arguments] : messages) gaze += of_gaze(address) ? 1 : 0;
      if (i == 0) {
        EXPECT_EQ(std::get<bool>(messages.at(parameter("FT/EyeTrackingActive"))[0]), looks);
        EXPECT_TRUE(messages.contains(parameter("FT/v2/EyeLidLeft"))) << "a lid is no gaze";
      }
    }
    EXPECT_EQ(gaze > 0, looks) << static_cast<int>(p) << ": " << gaze;
  }
}

TEST(Vrchat, LeavesAnAvatarsEyesAloneThatNobodyLooksAt) {
  const VrchatAvatar avatar{"a",
                            "Fox",
                            {{parameter("v2/EyeLeftX"), Type::real},
                             {parameter("v2/EyeY1"), Type::truth},
                             {parameter("v2/EyeYNegative"), Type::truth},
                             {parameter("v2/JawOpen"), Type::real}}};
  auto encoder = VrchatEncoder::make({}, avatar);
  ASSERT_TRUE(encoder);
  face::OutputFrame frame = jaw(0.5F);
  frame.eyes_provenance = face::Provenance::predicted;
  frame.eyes_rad[0] = {0.2F, 0.3F};
  const auto messages = encoded(*encoder, frame, 0);
  EXPECT_EQ(messages.size(), 1U);
  EXPECT_TRUE(messages.contains(parameter("v2/JawOpen")));
}

TEST(Vrchat, OpensLidsOnceThatNobodySeesAnyMore) {
  const std::string closed = "/tracking/eye/EyesClosedAmount";
  auto encoder = VrchatEncoder::make({});
  ASSERT_TRUE(encoder);
  face::OutputFrame frame = jaw(0);
  for (const char* lid : {"eyeBlink_L", "eyeBlink_R"}) {
    frame.weights[face::shape_index(lid)] = 1;
    frame.provenance[face::shape_index(lid)] = face::Provenance::measured;
  }
  EXPECT_EQ(std::get<float>(encoded(*encoder, frame, 0).at(closed)[0]), 1);
  for (const char* lid : {"eyeBlink_L", "eyeBlink_R"})
    frame.provenance[face::shape_index(lid)] = face::Provenance::neutral;
  EXPECT_EQ(std::get<float>(encoded(*encoder, frame, 1).at(closed)[0]), 0);
  for (std::int64_t i = 2; i < 130; ++i) EXPECT_FALSE(encoded(*encoder, frame, i).contains(closed)) << i;
}

TEST(Vrchat, WritesBinariesUnderAPrefix) {
  auto encoder = VrchatEncoder::make({.prefix = "FT/", .binary_bits = 3});
  ASSERT_TRUE(encoder);
  face::OutputFrame frame;
  frame.weights[face::shape("jawLeft")] = 0.6F;
  const auto messages = encoded(*encoder, frame, 0);
  EXPECT_FLOAT_EQ(std::get<float>(messages.at(parameter("FT/v2/JawX"))[0]), -0.6F);
  EXPECT_EQ(std::get<bool>(messages.at(parameter("FT/v2/JawX1"))[0]), false);
  EXPECT_EQ(std::get<bool>(messages.at(parameter("FT/v2/JawX2"))[0]), false);
  EXPECT_EQ(std::get<bool>(messages.at(parameter("FT/v2/JawX4"))[0]), true);
  EXPECT_EQ(std::get<bool>(messages.at(parameter("FT/v2/JawXNegative"))[0]), true);
  EXPECT_TRUE(messages.contains(parameter("FT/EyeTrackingActive")));
  EXPECT_FALSE(messages.contains(parameter("v2/JawOpen")));
  EXPECT_FALSE(VrchatEncoder::make({.binary_bits = 8}));
  EXPECT_FALSE(VrchatEncoder::make({.prefix = "a b"}));
}

TEST(Vrchat, SendsAnAvatarWhatItDeclares) {
  const VrchatAvatar avatar{"avtr_1",
                            "Fox",
                            {{parameter("FT/v2/JawOpen"), Type::real},
                             {parameter("FT/v2/JawX1"), Type::truth},
                             {parameter("FT/v2/JawX2"), Type::truth},
                             {parameter("FT/v2/JawX4"), Type::truth},
                             {parameter("FT/v2/MouthX1"), Type::truth},
                             {parameter("FT/v2/MouthX2"), Type::truth},
                             {parameter("FT/v2/MouthXNegative"), Type::truth},
                             {parameter("FT/v2/TongueOut"), Type::truth},
                             {parameter("FT/v2/EyeLeftX"), Type::real},
                             {parameter("FT/LipTrackingActive"), Type::truth},
                             // None of these is ours to send.
                             {parameter("JawOpen"), Type::real},
                             {parameter("Hat"), Type::truth},
                             {parameter("FT/v2/JawOpen3"), Type::truth},
                             {parameter("FT/v2/JawOpen128"), Type::truth},
                             {parameter("FT/v2/JawOpen04"), Type::truth},
                             {parameter("FT/v2/JawForward"), Type::whole},
                             {parameter("FT/v2/JawLeft1"), Type::real},
                             {parameter("FT/v2/Nothing"), Type::real},
                             {parameter("EyeTrackingActive"), Type::real}}};
  auto encoder = VrchatEncoder::make({}, avatar);
  ASSERT_TRUE(encoder) << encoder.error().message();
  face::OutputFrame frame = jaw(0.5F);
  frame.tongue_out = 0.75F;
  frame.weights[face::shape("jawRight")] = 0.5F;
  frame.weights[face::shape("mouthLeft")] = 0.5F;
  frame.provenance[0] = frame.provenance[face::shape("eyeBlink_R")] = face::Provenance::measured;
  frame.eyes_provenance = face::Provenance::measured;
  const auto messages = encoded(*encoder, frame, 0);
  const auto truth = [&](const char* name) { return std::get<bool>(messages.at(parameter(name))[0]); };
  EXPECT_EQ(messages.size(), 11u);
  EXPECT_EQ(std::get<float>(messages.at(parameter("FT/v2/JawOpen"))[0]), 0.5F);
  EXPECT_FALSE(truth("FT/v2/JawX1"));
  EXPECT_FALSE(truth("FT/v2/JawX2"));
  EXPECT_TRUE(truth("FT/v2/JawX4"));
  EXPECT_FALSE(truth("FT/v2/MouthX1"));
  EXPECT_TRUE(truth("FT/v2/MouthX2"));
  EXPECT_TRUE(truth("FT/v2/MouthXNegative"));
  EXPECT_TRUE(truth("FT/v2/TongueOut"));
  EXPECT_TRUE(truth("FT/LipTrackingActive"));
  EXPECT_TRUE(messages.contains(parameter("FT/v2/EyeLeftX")));
  // It turns its eyes itself; its lids are VRChat's.
  EXPECT_FALSE(messages.contains("/tracking/eye/LeftRightPitchYaw"));
  EXPECT_TRUE(messages.contains("/tracking/eye/EyesClosedAmount"));
}

TEST(Vrchat, SaysWhenAnAvatarHasNoFace) {
  const auto encoder = VrchatEncoder::make({}, {"a", "Stone", {{parameter("Hat"), Type::truth}}});
  ASSERT_FALSE(encoder);
  EXPECT_EQ(encoder.error().code, ErrorCode::mismatch);
  EXPECT_THAT(encoder.error().message(), ::testing::HasSubstr("Stone"));
}

}  // namespace
}  // namespace mien::sink::vrchat_test
