#include "mien/face/profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace mien::face::profile_test {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> slice(const Profile& profile, std::size_t first, std::size_t count) {
  return {profile.shapes.begin() + static_cast<std::ptrdiff_t>(first),
          profile.shapes.begin() + static_cast<std::ptrdiff_t>(first + count)};
}

constexpr std::array kOrders = {ArkitOrder::live_link_udp, ArkitOrder::live_link_csv,
                                ArkitOrder::live_link_csv_right, ArkitOrder::alphabetical, ArkitOrder::vts};

TEST(Profile, EveryArkitOrderHoldsTheSame52Names) {
  const std::set<std::string> names(arkit52().shapes.begin(), arkit52().shapes.end());
  ASSERT_EQ(names.size(), 52U);
  for (const ArkitOrder order : kOrders) {
    const Profile& profile = arkit52(order);
    EXPECT_EQ(profile.shapes.size(), 52U) << profile.name;
    EXPECT_EQ(std::set<std::string>(profile.shapes.begin(), profile.shapes.end()), names) << profile.name;
  }
}

TEST(Profile, OrdersDifferWhereTheFactsSayTheyDo) {
  EXPECT_THAT(slice(arkit52(ArkitOrder::live_link_udp), 14, 4),
              ElementsAre("jawForward", "jawLeft", "jawRight", "jawOpen"));
  EXPECT_THAT(slice(arkit52(ArkitOrder::live_link_udp), 21, 2), ElementsAre("mouthLeft", "mouthRight"));
  EXPECT_THAT(slice(arkit52(ArkitOrder::live_link_csv), 15, 2), ElementsAre("jawRight", "jawLeft"));
  EXPECT_THAT(slice(arkit52(ArkitOrder::live_link_csv), 21, 2), ElementsAre("mouthRight", "mouthLeft"));
  EXPECT_THAT(slice(arkit52(ArkitOrder::live_link_csv), 0, 1), ElementsAre("eyeBlinkLeft"));
  EXPECT_THAT(slice(arkit52(ArkitOrder::live_link_csv_right), 0, 1), ElementsAre("eyeBlinkRight"));
  EXPECT_THAT(slice(arkit52(ArkitOrder::live_link_csv_right), 6, 2),
              ElementsAre("eyeWideRight", "eyeBlinkLeft"));
  EXPECT_THAT(slice(arkit52(ArkitOrder::live_link_csv_right), 14, 11),
              ElementsAre("jawForward", "jawRight", "jawLeft", "jawOpen", "mouthClose", "mouthFunnel",
                          "mouthPucker", "mouthRight", "mouthLeft", "mouthSmileRight", "mouthSmileLeft"));
  EXPECT_THAT(slice(arkit52(ArkitOrder::vts), 15, 2), ElementsAre("jawRight", "jawLeft"));
  EXPECT_THAT(slice(arkit52(ArkitOrder::vts), 21, 2), ElementsAre("mouthLeft", "mouthRight"));
  EXPECT_TRUE(std::ranges::is_sorted(arkit52(ArkitOrder::alphabetical).shapes));
  EXPECT_EQ(arkit52(ArkitOrder::alphabetical).shapes.back(), "tongueOut");
}

TEST(Profile, MediaPipeHasANeutralAndNoTongue) {
  const Profile& profile = mediapipe52();
  ASSERT_EQ(profile.shapes.size(), 52U);
  EXPECT_EQ(profile.shapes[0], "_neutral");
  EXPECT_EQ(profile.shapes[25], "jawOpen");
  EXPECT_EQ(profile.shapes[51], "noseSneerRight");
  EXPECT_EQ(std::ranges::count(profile.shapes, "tongueOut"), 0);
}

TEST(Profile, NamesAreFoundInAnyCaseAndWithShortSides) {
  EXPECT_EQ(arkit_index("eyeBlinkLeft"), 0U);
  EXPECT_EQ(arkit_index("EyeBlinkLeft"), 0U);
  EXPECT_EQ(arkit_index("EYEBLINK_L"), 0U);
  EXPECT_EQ(arkit_index("mouthSmile_R"), 24U);
  EXPECT_EQ(arkit_index("mouthLeft"), 21U);
  EXPECT_EQ(arkit_index("tongueOut"), 51U);
  EXPECT_EQ(arkit_index("browInnerUp"), 43U);
  for (const char* unknown :
       {"", "_L", "jaw_L", "mouth_L", "eyeBlink", "eyeBlink_X", "browInnerUp_L", "_neutral"})
    EXPECT_EQ(arkit_index(unknown), 52U) << unknown;
}

TEST(Profile, ArkitComesBackFromIctUnchanged) {
  ArkitWeights arkit;
  for (std::size_t i = 0; i < 52; ++i) arkit.values[i] = 0.001F * static_cast<float>(i + 1);
  float tongue = 0;
  const BlendshapeWeights ict = ict_from_arkit(arkit, &tongue);
  EXPECT_FLOAT_EQ(tongue, 0.052F);
  EXPECT_EQ(ict[shape("browInnerUp_L")], arkit.values[arkit_index("browInnerUp")]);
  EXPECT_EQ(ict[shape("browInnerUp_R")], arkit.values[arkit_index("browInnerUp")]);
  EXPECT_EQ(ict[shape("jawLeft")], arkit.values[arkit_index("jawLeft")]);
  EXPECT_EQ(ict[shape("eyeWide_R")], arkit.values[arkit_index("eyeWideRight")]);
  for (std::size_t k = 0; k < kShapeCount; ++k) EXPECT_GT(ict[k], 0) << kShapeNames[k];
  EXPECT_EQ(arkit_from_ict(ict, tongue, false).values, arkit.values);
}

TEST(Profile, TheWayBackTakesTheMeanOfTheSidesAndHoldsMouthClose) {
  BlendshapeWeights ict;
  ict[shape("cheekPuff_L")] = 1;
  ict[shape("browInnerUp_R")] = 0.5F;
  ict[shape("jawOpen")] = 0.2F;
  ict[shape("mouthClose")] = 0.7F;
  const ArkitWeights held = arkit_from_ict(ict, 0.25F, true);
  EXPECT_EQ(held.values[arkit_index("cheekPuff")], 0.5F);
  EXPECT_EQ(held.values[arkit_index("browInnerUp")], 0.25F);
  EXPECT_EQ(held.values[arkit_index("mouthClose")], 0.2F);
  EXPECT_EQ(held.values[arkit_index("tongueOut")], 0.25F);
  EXPECT_EQ(arkit_from_ict(ict, 0, false).values[arkit_index("mouthClose")], 0.7F);
}

}  // namespace
}  // namespace mien::face::profile_test
