#include "mien/sink/unified.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>
#include <string>

#include "mien/core/random.h"

namespace mien::sink::unified_test {
namespace {

ArkitFrame with(std::initializer_list<std::pair<const char*, float>> weights) {
  ArkitFrame frame;
  for (const auto& [name, value] : weights) {
    EXPECT_LT(face::arkit_index(name), 52u) << name;
    frame.weights.values[face::arkit_index(name)] = value;
  }
  return frame;
}

std::map<std::string, float> parameters(const ArkitFrame& frame) {
  std::map<std::string, float> values;
  const UnifiedFrame unified = unified_frame(frame);
  for (const auto& parameter : unified_parameters())
    values[std::string(parameter.name)] = parameter.of(unified);
  return values;
}

TEST(Unified, NamesEachParameterOnceAndWithoutDigits) {
  std::set<std::string_view> names;
  for (const auto& parameter : unified_parameters()) {
    EXPECT_TRUE(names.insert(parameter.name).second) << parameter.name;
    EXPECT_FALSE(std::isdigit(static_cast<unsigned char>(parameter.name.back()))) << parameter.name;
    EXPECT_FALSE(parameter.name.ends_with("Negative")) << parameter.name;
  }
  EXPECT_EQ(kUnifiedNames[22], "JawOpen");
  EXPECT_EQ(kUnifiedNames[72], "TongueOut");
  EXPECT_EQ(kUnifiedNames[87], "NeckFlexLeft");
}

TEST(Unified, EveryArkitShapeMovesSomething) {
  const auto still = parameters({});
  for (const std::string& name : face::arkit52().shapes) {
    if (name.starts_with("eyeLook")) continue;  // The gaze comes from the eyes' own directions.
    EXPECT_NE(parameters(with({{name.c_str(), 1.0F}})), still) << name;
  }
}

TEST(Unified, WhatArkitDoesNotKnowStaysAtRest) {
  ArkitFrame all;
  all.weights.values.fill(1);
  const auto values = parameters(all);
  for (const char* name : {"CheekSuckLeft", "MouthTightenerLeft", "NasalDilationRight", "JawClench",
                           "JawBackward", "LipSuckCornerLeft", "TongueUp", "NeckFlexLeft"})
    EXPECT_EQ(values.at(name), 0) << name;
}

TEST(Unified, FollowsTheFormulas) {
  auto v =
      parameters(with({{"mouthSmileLeft", 0.5F}, {"mouthFrownLeft", 0.25F}, {"mouthStretchLeft", 0.375F}}));
  EXPECT_FLOAT_EQ(v.at("MouthCornerPullLeft"), 0.5F);
  EXPECT_FLOAT_EQ(v.at("MouthSmileLeft"), 0.5F);
  EXPECT_FLOAT_EQ(v.at("SmileFrownLeft"), 0.25F);
  EXPECT_FLOAT_EQ(v.at("SmileSadLeft"), 0.125F);
  EXPECT_FLOAT_EQ(v.at("SmileSad"), 0.0625F);
  EXPECT_FLOAT_EQ(v.at("MouthCornerYLeft"), 0.25F);
  EXPECT_FLOAT_EQ(v.at("MouthTightenerStretchLeft"), -0.375F);
  EXPECT_EQ(v.at("SmileFrownRight"), 0);

  v = parameters(with({{"browDownRight", 0.5F}, {"browInnerUp", 0.4F}, {"browOuterUpRight", 0.2F}}));
  EXPECT_FLOAT_EQ(v.at("BrowPinchRight"), 0.5F);
  EXPECT_FLOAT_EQ(v.at("BrowDownRight"), 0.5F);
  EXPECT_FLOAT_EQ(v.at("BrowDownLeft"), 0);
  EXPECT_FLOAT_EQ(v.at("BrowUpRight"), 0.28F);
  EXPECT_FLOAT_EQ(v.at("BrowUpLeft"), 0.16F);
  EXPECT_FLOAT_EQ(v.at("BrowExpressionRight"), -0.2F);
  EXPECT_FLOAT_EQ(v.at("BrowOuterUp"), 0.1F);

  v = parameters(with({{"jawRight", 0.5F}, {"jawLeft", 0.125F}, {"jawForward", 0.75F}, {"mouthLeft", 0.5F}}));
  EXPECT_FLOAT_EQ(v.at("JawX"), 0.375F);
  EXPECT_FLOAT_EQ(v.at("JawZ"), 0.75F);
  EXPECT_FLOAT_EQ(v.at("MouthX"), -0.5F);
  EXPECT_FLOAT_EQ(v.at("MouthUpperLeft"), 0.5F);

  v = parameters(with({{"mouthFunnel", 0.5F}, {"mouthRollUpper", 0.75F}, {"mouthPucker", 0.25F}}));
  EXPECT_FLOAT_EQ(v.at("LipFunnelLowerLeft"), 0.5F);
  EXPECT_FLOAT_EQ(v.at("LipSuckFunnelUpper"), 0.25F);
  EXPECT_FLOAT_EQ(v.at("LipSuckFunnelLowerRight"), -0.5F);
  EXPECT_FLOAT_EQ(v.at("LipSuck"), 0.375F);
  EXPECT_FLOAT_EQ(v.at("LipPuckerLeft"), 0.25F);

  v = parameters(with({{"mouthUpperUpLeft", 1}, {"mouthLowerDownLeft", 0.5F}, {"mouthShrugUpper", 0.25F}}));
  EXPECT_FLOAT_EQ(v.at("MouthUpperDeepenLeft"), 1);
  EXPECT_FLOAT_EQ(v.at("MouthOpen"), 0.375F);
  EXPECT_FLOAT_EQ(v.at("MouthRaiserUpper"), 0.25F);
}

TEST(Unified, OpensAndTurnsTheEyes) {
  ArkitFrame frame = with({{"eyeBlinkLeft", 0.5F}, {"eyeSquintLeft", 0.5F}, {"eyeWideRight", 1}});
  // The left eye looks left and up, the right one 45 degrees right and far down.
  const float quarter = std::atan(0.25F);
  frame.eyes_rad = {Eigen::Vector2f(quarter, quarter), Eigen::Vector2f(-std::atan(1.0F), -1.4F)};
  const auto v = parameters(frame);
  EXPECT_FLOAT_EQ(v.at("EyeOpenLeft"), 0.25F);
  EXPECT_FLOAT_EQ(v.at("EyeClosedLeft"), 0.75F);
  EXPECT_FLOAT_EQ(v.at("EyeLidLeft"), 0.1875F);
  EXPECT_FLOAT_EQ(v.at("EyeLidRight"), 1);
  EXPECT_FLOAT_EQ(v.at("EyeWide"), 1);
  EXPECT_FLOAT_EQ(v.at("EyesSquint"), 0.5F);
  EXPECT_FLOAT_EQ(v.at("EyeLeftX"), -0.25F);
  EXPECT_FLOAT_EQ(v.at("EyeLeftY"), 0.25F);
  EXPECT_FLOAT_EQ(v.at("EyeRightX"), 1);
  EXPECT_FLOAT_EQ(v.at("EyeRightY"), -1);
  EXPECT_FLOAT_EQ(v.at("EyeX"), 0.375F);
}

TEST(Unified, StaysWithinBounds) {
  Random random(11);
  for (int i = 0; i < 500; ++i) {
    ArkitFrame frame;
    for (float& w : frame.weights.values) w = static_cast<float>(random.uniform());
    for (auto& eye : frame.eyes_rad)
      eye = {static_cast<float>(random.uniform(-1.5, 1.5)), static_cast<float>(random.uniform(-1.5, 1.5))};
    for (const auto& [name, value] : parameters(frame)) {
      EXPECT_GE(value, -1.0001F) << name;
      EXPECT_LE(value, 1.0001F) << name;
    }
  }
}

}  // namespace
}  // namespace mien::sink::unified_test
