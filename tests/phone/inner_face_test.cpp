#include "mien/phone/inner_face.h"

#include <gtest/gtest.h>

#include "mien/core/random.h"

namespace mien::phone::inner_face_test {
namespace {

using face::inner_index;

/// Of a face that tells these shapes of a set.
InnerFace told(ShapeSet set, const std::vector<std::pair<std::string_view, float>>& shapes,
               Origin origin = Origin::measured, float confidence = kUntold) {
  ToldFace face;
  face.set = set;
  face.origin = origin;
  for (const auto& [name, weight] : shapes) {
    std::size_t i = 0;
    while (i < count_of(set) && shape_name(set, i) != name) ++i;
    EXPECT_LT(i, count_of(set)) << name;
    face.weights[i] = weight;
    face.confidence[i] = confidence;
  }
  return inner_face(face);
}

std::size_t known_count(const InnerFace& inner) {
  return static_cast<std::size_t>(std::ranges::count(inner.known, true));
}

TEST(InnerFace, OursPassAndAreHeldToTheirRange) {
  const InnerFace inner =
      told(ShapeSet::ict53, {{"jawOpen", 0.25F}, {"mouthLeft", 1.5F}, {"tongueOut", -0.5F}});
  EXPECT_EQ(known_count(inner), 3U);
  EXPECT_EQ(inner.weights[inner_index("jawOpen")], 0.25F);
  EXPECT_EQ(inner.weights[inner_index("mouthLeft")], 1);
  EXPECT_EQ(inner.weights[inner_index("tongueOut")], 0);
  EXPECT_TRUE(inner.known[inner_index("tongueOut")]);
}

TEST(InnerFace, OnlyWhatIsToldIsKnown) {
  const InnerFace inner = told(ShapeSet::arkit52, {{"browInnerUp", 0.5F}, {"jawOpen", 0}});
  EXPECT_EQ(known_count(inner), 3U);
  EXPECT_EQ(inner.weights[inner_index("browInnerUp_L")], 0.5F);
  EXPECT_EQ(inner.weights[inner_index("browInnerUp_R")], 0.5F);
  EXPECT_TRUE(inner.known[inner_index("jawOpen")]) << "told to be 0";
  EXPECT_EQ(known_count(told(ShapeSet::unified, {{"JawClench", 1}})), 0U) << "without a counterpart";
}

TEST(InnerFace, ASubsetOfWhatAShapeIsMadeOfIsLessSure) {
  // mouthFunnel is the mean of four.
  const InnerFace two = told(ShapeSet::openxr_fb_63, {{"LIP_FUNNELER_LB", 0.5F}, {"LIP_FUNNELER_RB", 0.25F}},
                             Origin::measured, 1);
  const std::size_t funnel = inner_index("mouthFunnel");
  EXPECT_EQ(known_count(two), 1U);
  EXPECT_FLOAT_EQ(two.weights[funnel], 0.375F);
  EXPECT_FLOAT_EQ(two.confidence[funnel], 0.5F);
  // browDown is BrowLowerer by three quarters.
  const InnerFace pinch = told(ShapeSet::unified, {{"BrowPinchLeft", 0.8F}}, Origin::measured, 0.5F);
  EXPECT_FLOAT_EQ(pinch.weights[inner_index("browDown_L")], 0.8F);
  EXPECT_FLOAT_EQ(pinch.confidence[inner_index("browDown_L")], 0.125F);
}

TEST(InnerFace, AWholeFaceIsItsSetsTable) {
  Random random(3);
  for (std::size_t s = 1; s < kShapeSetCount; ++s) {
    ToldFace face;
    face.set = static_cast<ShapeSet>(s);
    const std::size_t count = count_of(face.set);
    for (std::size_t i = 0; i < count; ++i) face.weights[i] = static_cast<float>(random.uniform(0, 1));
    float tongue = 0;
    const auto expected = map_of(face.set)->to_ict(std::span(face.weights).first(count), &tongue);
    const InnerFace inner = inner_face(face);
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      EXPECT_NEAR(inner.weights[k], expected[k], 1e-6) << name_of(face.set) << ' ' << face::kShapeNames[k];
    EXPECT_NEAR(inner.weights[face::kShapeCount], tongue, 1e-6);
    EXPECT_EQ(known_count(inner) + map_of(face.set)->lacks.size(), face::kInnerCount) << name_of(face.set);
  }
}

TEST(InnerFace, WhoDoesNotSayHowSureIsHalfSureAndWhoHoldsIsNot) {
  const std::size_t jaw = inner_index("jawOpen");
  EXPECT_EQ(told(ShapeSet::arkit52, {{"jawOpen", 1}}).confidence[jaw], kDefaultConfidence);
  EXPECT_EQ(told(ShapeSet::arkit52, {{"jawOpen", 1}}, Origin::measured, 0.75F).confidence[jaw], 0.75F);
  const InnerFace held = told(ShapeSet::arkit52, {{"jawOpen", 1}}, Origin::held, 0.75F);
  EXPECT_EQ(held.confidence[jaw], 0);
  EXPECT_EQ(held.weights[jaw], 1);
}

TEST(InnerFace, ProvenanceIsWhatTheSenderSaysOfItself) {
  using face::Provenance;
  EXPECT_EQ(provenance_of(Origin::measured), Provenance::measured);
  EXPECT_EQ(provenance_of(Origin::predicted), Provenance::predicted);
  EXPECT_EQ(provenance_of(Origin::untold), Provenance::predicted);
  EXPECT_EQ(provenance_of(Origin::audio), Provenance::audio);
  EXPECT_EQ(provenance_of(Origin::held), Provenance::held);
}

}  // namespace
}  // namespace mien::phone::inner_face_test
