#include "mien/face/profile_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <initializer_list>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mien/core/random.h"
#include "tests/allocation_count.h"

namespace mien::face::profile_map_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Named = std::map<std::string_view, float>;

const ProfileMap& unified() {
  return profile_map(OutsideProfile::unified);
}

/// What is not 0 of a profile, of inner weights by name.
Named outward(const ProfileMap& map, std::initializer_list<std::pair<std::string_view, float>> weights) {
  BlendshapeWeights ict;
  float tongue_out = 0;
  for (const auto& [name, value] : weights) {
    const std::size_t k = inner_index(name);
    EXPECT_LT(k, kInnerCount) << name;
    (k < kShapeCount ? ict[k] : tongue_out) = value;
  }
  std::vector<float> out(map.shapes.size(), -1);
  map.from_ict(ict, tongue_out, out);
  Named named;
  for (std::size_t i = 0; i < out.size(); ++i)
    if (out[i] != 0) named[map.shapes[i]] = out[i];
  return named;
}

/// What is not 0 inside, of a profile's weights by name.
Named inward(const ProfileMap& map, std::initializer_list<std::pair<std::string_view, float>> weights) {
  std::vector<float> in(map.shapes.size(), 0);
  for (const auto& [name, value] : weights) {
    const auto found = std::ranges::find(map.shapes, name);
    EXPECT_NE(found, map.shapes.end()) << name;
    in[static_cast<std::size_t>(found - map.shapes.begin())] = value;
  }
  float tongue_out = 0;
  const BlendshapeWeights ict = map.to_ict(in, &tongue_out);
  Named named;
  for (std::size_t k = 0; k < kInnerCount; ++k)
    if (const float w = k < kShapeCount ? ict[k] : tongue_out; w != 0) named[inner_name(k)] = w;
  return named;
}

std::set<std::string_view> without(const ProfileMap& map) {
  std::set<std::string_view> names;
  for (const Unmatched& none : map.without) {
    EXPECT_FALSE(none.reason.empty());
    names.insert(map.shapes[none.shape]);
  }
  return names;
}

TEST(ProfileMap, HaveTheirPublishedCountsAndNoNameTwice) {
  const std::map<std::string_view, std::size_t> counts = {
      {"arkit52", 52}, {"openxr_fb_63", 63}, {"openxr_fb_70", 70}, {"refa_64", 64}, {"unified", 88}};
  ASSERT_EQ(profile_maps().size(), counts.size());
  for (const ProfileMap& map : profile_maps()) {
    ASSERT_EQ(map.shapes.size(), counts.at(map.name)) << map.name;
    EXPECT_EQ(std::set(map.shapes.begin(), map.shapes.end()).size(), map.shapes.size()) << map.name;
    EXPECT_EQ(*find_profile_map(std::string(map.name)), &map);
    EXPECT_FALSE(map.title.empty());
    EXPECT_FALSE(map.source.empty());
  }
  EXPECT_EQ(profile_map(OutsideProfile::refa_64).name, "refa_64");
  EXPECT_EQ(unified().name, "unified");
}

TEST(ProfileMap, RefaHasItsSevenGroups) {
  const ProfileMap& refa = profile_map(OutsideProfile::refa_64);
  std::map<std::string_view, std::size_t> counts;
  for (std::size_t i = 0; i < refa.shapes.size(); ++i) ++counts[refa.group_of(i)];
  const std::map<std::string_view, std::size_t> published = {
      {"brow", 6}, {"eye", 14}, {"cheek", 8}, {"mouth", 12}, {"upper lip", 11}, {"lower lip", 9}, {"jaw", 4}};
  EXPECT_EQ(counts, published);
  const auto in_group = [&](std::string_view group, std::string_view stem) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < refa.shapes.size(); ++i)
      count += refa.group_of(i) == group && refa.shapes[i].starts_with(stem) ? 1 : 0;
    return count;
  };
  EXPECT_EQ(in_group("eye", "eyesLook"), 8U);  // Controlled by gaze.
  EXPECT_EQ(in_group("upper lip", "lipsToward_") + in_group("lower lip", "lipsToward_"), 4U);
  EXPECT_EQ(in_group("jaw", "jaw"), 4U);
}

TEST(ProfileMap, TheFirst63OfOpenXrAreThoseOfItsFirstExtension) {
  const ProfileMap& first = profile_map(OutsideProfile::openxr_fb_63);
  const ProfileMap& second = profile_map(OutsideProfile::openxr_fb_70);
  EXPECT_TRUE(std::ranges::equal(first.shapes, second.shapes.first(63)));
  EXPECT_EQ(first.shapes[24], "JAW_DROP");
  EXPECT_EQ(first.shapes[62], "UPPER_LIP_RAISER_R");
  EXPECT_EQ(second.shapes[68], "TONGUE_OUT");
}

/// Of whatever performance, a little beyond 0 to 1 too.
TEST(ProfileMap, IctComesBackFromEveryProfileUnchanged) {
  Random random(5);
  for (const ProfileMap& map : profile_maps()) {
    SCOPED_TRACE(map.name);
    std::vector<bool> told(kInnerCount, true);
    for (const Unmatched& lack : map.lacks) told[lack.shape] = false;
    std::vector<float> outside(map.shapes.size());
    for (int i = 0; i < 200; ++i) {
      BlendshapeWeights ict;
      for (float& w : ict.values) w = static_cast<float>(random.uniform(-0.1, 1.2));
      // ARKit does not tell their sides apart.
      if (map.name == "arkit52")
        for (const char* stem : {"browInnerUp", "cheekPuff"})
          ict[shape_index(std::string(stem) + "_R")] = ict[shape_index(std::string(stem) + "_L")];
      map.from_ict(ict, 0.375F, outside);
      float tongue_out = -1;
      const BlendshapeWeights back = map.to_ict(outside, &tongue_out);
      for (std::size_t k = 0; k < kShapeCount; ++k)
        EXPECT_NEAR(back[k], told[k] ? ict[k] : 0.0F, 1e-6) << kShapeNames[k];
      EXPECT_EQ(tongue_out, told[kShapeCount] ? 0.375F : 0.0F);
    }
  }
}

TEST(ProfileMap, SaysWhatHasNoCounterpart) {
  EXPECT_TRUE(profile_map(OutsideProfile::arkit52).without.empty());
  EXPECT_THAT(without(profile_map(OutsideProfile::openxr_fb_63)),
              ElementsAre("CHEEK_SUCK_L", "CHEEK_SUCK_R", "LIP_TIGHTENER_L", "LIP_TIGHTENER_R"));
  EXPECT_THAT(
      without(profile_map(OutsideProfile::openxr_fb_70)),
      ElementsAre("CHEEK_SUCK_L", "CHEEK_SUCK_R", "LIP_TIGHTENER_L", "LIP_TIGHTENER_R",
                  "TONGUE_BACK_DORSAL_VELAR", "TONGUE_FRONT_DORSAL_PALATE", "TONGUE_MID_DORSAL_PALATE",
                  "TONGUE_RETREAT", "TONGUE_TIP_ALVEOLAR", "TONGUE_TIP_INTERDENTAL"));
  EXPECT_THAT(without(profile_map(OutsideProfile::refa_64)), ElementsAre("cheekSuck_L", "cheekSuck_R"));
  EXPECT_EQ(unified().without.size(), 28U);

  const std::map<std::string_view, std::size_t> lacks = {
      {"arkit52", 0}, {"openxr_fb_63", 1}, {"openxr_fb_70", 0}, {"refa_64", 1}, {"unified", 10}};
  for (const ProfileMap& map : profile_maps()) {
    EXPECT_EQ(map.lacks.size(), lacks.at(map.name)) << map.name;
    for (const Unmatched& lack : map.lacks) {
      EXPECT_FALSE(lack.reason.empty());
      const std::string_view name = inner_name(lack.shape);
      EXPECT_TRUE(name.starts_with("eyeLook") || name.starts_with("eyeBlink") || name == "tongueOut") << name;
    }
    // With all that there is inside, what has none stays at rest, and nothing else does.
    std::vector<float> out(map.shapes.size(), -1);
    BlendshapeWeights all;
    all.values.fill(1);
    map.from_ict(all, 1, out);
    const auto none = without(map);
    for (std::size_t i = 0; i < out.size(); ++i)
      EXPECT_EQ(out[i], none.contains(map.shapes[i]) ? 0.0F : 1.0F) << map.name << " " << map.shapes[i];
  }
}

TEST(ProfileMap, CountsMeansAndDivisions) {
  const std::map<std::string_view, std::pair<std::size_t, std::size_t>> counts = {
      {"arkit52", {2, 0}},       // browInnerUp, cheekPuff.
      {"openxr_fb_63", {0, 4}},  // mouthFunnel, mouthPucker, mouthRollLower, mouthRollUpper.
      {"openxr_fb_70", {0, 4}},  // As above.
      {"refa_64", {0, 5}},       // And mouthClose.
      {"unified",
       {0, 12}}};  // Two brows, two smiles, two upper lips; both ways of the mouth; four lip shapes.
  for (const ProfileMap& map : profile_maps())
    EXPECT_EQ(std::pair(map.merged_count(), map.divided_count()), counts.at(map.name)) << map.name;
}

TEST(ProfileMap, GoesOutAsTheTablesSay) {
  const ProfileMap& fb = profile_map(OutsideProfile::openxr_fb_70);
  // The left eye looks out where it looks left, the right one in.
  EXPECT_EQ(outward(fb, {{"eyeLookOut_L", 0.5F}, {"eyeLookIn_R", 0.25F}}),
            (Named{{"EYES_LOOK_LEFT_L", 0.5F}, {"EYES_LOOK_LEFT_R", 0.25F}}));
  EXPECT_EQ(
      outward(fb, {{"mouthRollUpper", 0.75F}, {"tongueOut", 0.5F}, {"mouthClose", 0.25F}}),
      (Named{{"LIP_SUCK_LT", 0.75F}, {"LIP_SUCK_RT", 0.75F}, {"TONGUE_OUT", 0.5F}, {"LIPS_TOWARD", 0.25F}}));
  EXPECT_EQ(outward(profile_map(OutsideProfile::refa_64), {{"mouthClose", 0.5F}, {"jawOpen", 0.75F}}),
            (Named{{"lipsToward_LB", 0.5F},
                   {"lipsToward_LT", 0.5F},
                   {"lipsToward_RB", 0.5F},
                   {"lipsToward_RT", 0.5F},
                   {"jawDrop", 0.75F}}));
  EXPECT_EQ(outward(unified(), {{"mouthSmile_L", 0.5F}, {"mouthRight", 0.25F}}),
            (Named{{"MouthCornerPullLeft", 0.5F},
                   {"MouthCornerSlantLeft", 0.5F},
                   {"MouthUpperRight", 0.25F},
                   {"MouthLowerRight", 0.25F}}));
  EXPECT_EQ(outward(unified(), {{"eyeBlink_L", 1}, {"eyeLookUp_R", 1}}), Named{});
  EXPECT_EQ(outward(profile_map(OutsideProfile::arkit52), {{"cheekPuff_L", 1}, {"browDown_R", 0.5F}}),
            (Named{{"cheekPuff", 0.5F}, {"browDownRight", 0.5F}}));
}

TEST(ProfileMap, ComesInAsTheTablesSay) {
  const ProfileMap& fb = profile_map(OutsideProfile::openxr_fb_63);
  EXPECT_EQ(inward(fb, {{"LIP_FUNNELER_LB", 1}, {"LIP_FUNNELER_RT", 0.5F}, {"LIP_PUCKER_L", 0.5F}}),
            (Named{{"mouthFunnel", 0.375F}, {"mouthPucker", 0.25F}}));
  EXPECT_EQ(inward(fb, {{"CHEEK_SUCK_L", 1}, {"LIP_TIGHTENER_R", 1}}), Named{});
  EXPECT_EQ(inward(fb, {{"EYES_LOOK_RIGHT_L", 0.5F}, {"EYES_LOOK_RIGHT_R", 0.25F}}),
            (Named{{"eyeLookIn_L", 0.5F}, {"eyeLookOut_R", 0.25F}}));
  EXPECT_EQ(inward(unified(), {{"BrowLowererLeft", 1}, {"BrowPinchRight", 1}, {"TongueOut", 1}}),
            (Named{{"browDown_L", 0.75F}, {"browDown_R", 0.25F}, {"tongueOut", 1.0F}}));
  EXPECT_EQ(inward(unified(), {{"MouthUpperDeepenLeft", 1}, {"MouthUpperUpRight", 0.5F}}),
            (Named{{"mouthUpperUp_R", 0.5F}}));
  EXPECT_EQ(inward(unified(), {{"MouthUpperLeft", 1}}), (Named{{"mouthLeft", 0.5F}}));
  EXPECT_EQ(inward(profile_map(OutsideProfile::arkit52), {{"browInnerUp", 0.5F}}),
            (Named{{"browInnerUp_L", 0.5F}, {"browInnerUp_R", 0.5F}}));
}

/// What one weight becomes, it becomes bit by bit: the sink promises its receivers the bits.
TEST(ProfileMap, ArkitAndUnifiedKeepBits) {
  Random random(8);
  BlendshapeWeights ict;
  for (float& w : ict.values) w = static_cast<float>(random.uniform());
  ict[shape("mouthClose")] = -0.0F;
  const ArkitWeights arkit = arkit_from_ict(ict, 0.3F, false);
  EXPECT_EQ(arkit.values[arkit_index("cheekPuff")],
            0.5F * (ict[shape("cheekPuff_L")] + ict[shape("cheekPuff_R")]));
  EXPECT_TRUE(std::signbit(arkit.values[arkit_index("mouthClose")]));
  std::vector<float> out(kUnifiedCount);
  unified().from_ict(ict, 0.3F, out);
  const auto at = [&](std::string_view name) {
    return out[static_cast<std::size_t>(std::ranges::find(kUnifiedNames, name) - kUnifiedNames.begin())];
  };
  EXPECT_EQ(std::bit_cast<std::uint32_t>(at("BrowPinchRight")),
            std::bit_cast<std::uint32_t>(ict[shape("browDown_R")]));
  EXPECT_TRUE(std::signbit(at("MouthClosed")));
}

TEST(ProfileMap, TakesSpansOfAnyLength) {
  BlendshapeWeights ict;
  ict.values.fill(0.5F);
  std::array<float, 3> few{};
  unified().from_ict(ict, 0, few);
  EXPECT_THAT(few, ElementsAre(0.5F, 0.5F, 0.5F));
  std::vector<float> many(kUnifiedCount + 2, 7);
  unified().from_ict(ict, 0, many);
  EXPECT_EQ(many[kUnifiedCount], 7);
  EXPECT_EQ(unified().to_ict({}), BlendshapeWeights());
  EXPECT_EQ(unified().to_ict(few)[shape("eyeSquint_R")], 0.5F);
}

TEST(ProfileMap, AllocatesNothing) {
  BlendshapeWeights ict;
  ict.values.fill(0.5F);
  std::array<float, kUnifiedCount> out{};
  const std::size_t before = test::allocation_count();
  float tongue_out = 0;
  for (const ProfileMap& map : profile_maps()) {
    map.from_ict(ict, 0.5F, out);
    ict = map.to_ict(out, &tongue_out);
  }
  EXPECT_EQ(test::allocation_count(), before);
  static_assert(noexcept(profile_maps()[0].from_ict(ict, 0, out)));
  static_assert(noexcept(profile_maps()[0].to_ict(out)));
}

TEST(ProfileMap, AnUnknownNameIsAnsweredWithTheNearest) {
  const auto none = find_profile_map("refa64");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::not_found);
  EXPECT_THAT(none.error().message(), HasSubstr("did you mean refa_64?"));
}

}  // namespace
}  // namespace mien::face::profile_map_test
