// The names under which receivers look for a face's morph targets, on the built-in face.
#include "mien/face/morph_targets.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/random.h"
#include "mien/face/target_names.h"

namespace mien::face::morph_targets_test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;

const Face& builtin() {
  static const Face face = builtin_face::make_builtin();
  return face;
}

std::vector<std::string> names(const std::vector<MorphTarget>& targets) {
  std::vector<std::string> out;
  for (const MorphTarget& target : targets) out.push_back(target.name);
  return out;
}

/// How far at most the targets, at the weights that these give them, displace a vertex elsewhere than the
/// shapes.
float largest_difference_m(const std::vector<MorphTarget>& targets, const BlendshapeWeights& weights,
                           float tongue_out) {
  const Face& face = builtin();
  std::vector<Vec3f> expected(face.neutral_m.size()), moved = face.neutral_m;
  evaluate(face, weights, tongue_out, expected);
  for (const MorphTarget& target : targets)
    for (std::size_t i = 0; i < target.vertex.size(); ++i)
      moved[target.vertex[i]] += weight_of(target, weights, tongue_out) * target.delta_m[i];
  float largest = 0;
  for (std::size_t i = 0; i < moved.size(); ++i) largest = std::max(largest, (moved[i] - expected[i]).norm());
  return largest;
}

BlendshapeWeights drawn_weights() {
  Random random(5);
  BlendshapeWeights weights;
  for (float& weight : weights.values) weight = static_cast<float>(random.uniform(0, 1));
  // Of these ARKit has one for both sides.
  weights[shape("browInnerUp_R")] = weights[shape("browInnerUp_L")];
  weights[shape("cheekPuff_R")] = weights[shape("cheekPuff_L")];
  return weights;
}

TEST(MorphTargets, AppleNamesAreThereLetterForLetterAndMoveSomething) {
  const auto targets = morph_targets(builtin(), TargetNames::arkit);
  EXPECT_EQ(names(targets), arkit52().shapes);
  for (const MorphTarget& target : targets) {
    EXPECT_FALSE(target.vertex.empty()) << target.name;
    EXPECT_TRUE(std::ranges::is_sorted(target.vertex)) << target.name;
  }
}

TEST(MorphTargets, UnderAnyNamesTheyDisplaceTheFaceAsItsShapesDo) {
  const BlendshapeWeights weights = drawn_weights();
  for (const TargetNames of : {TargetNames::ict, TargetNames::arkit, TargetNames::unified})
    EXPECT_LT(largest_difference_m(morph_targets(builtin(), of), weights, 0.4F), 1e-6F)
        << static_cast<int>(of);
}

TEST(MorphTargets, UnifiedExpressionsDivideLipsBySideAndByJaw) {
  const auto targets = morph_targets(builtin(), TargetNames::unified);
  const auto all = names(targets);
  for (const char* name :
       {"EyeClosedLeft", "BrowPinchRight", "MouthCornerSlantLeft", "LipSuckLowerRight", "JawForward",
        "MouthRaiserUpper", "CheekPuffLeft", "TongueOut", "MouthClosed", "EyeLookInRight"})
    EXPECT_THAT(all, Contains(name));
  std::vector<std::string> sorted = all;
  std::ranges::sort(sorted);
  EXPECT_EQ(std::ranges::adjacent_find(sorted), sorted.end()) << "no name twice";

  // Where a lip moves most: on its side, and on its side of the line between the lips.
  const auto peak = [&](const std::string& name) {
    const MorphTarget& target = *std::ranges::find(targets, name, &MorphTarget::name);
    const auto most = std::ranges::max_element(target.delta_m, {}, [](const Vec3f& d) { return d.norm(); });
    return builtin().neutral_m[target.vertex[static_cast<std::size_t>(most - target.delta_m.begin())]];
  };
  EXPECT_GT(peak("LipFunnelUpperLeft").x(), 0);
  EXPECT_LT(peak("LipFunnelUpperRight").x(), 0);
  EXPECT_GT(peak("LipFunnelUpperLeft").y(), peak("LipFunnelLowerLeft").y());
  EXPECT_GT(peak("LipPuckerUpperRight").y(), peak("LipPuckerLowerRight").y());
}

TEST(MorphTargets, AShapeThatAFaceLacksMovesNothingAndHasItsName) {
  Face face = builtin();
  face.shapes.resize(kShapeCount);
  face.shapes[shape("jawOpen")].vertex.clear();
  face.shapes[shape("jawOpen")].delta_m.clear();
  const std::pair<TargetNames, std::vector<std::string>> lacking[] = {
      {TargetNames::arkit, {"jawOpen", "tongueOut"}}, {TargetNames::unified, {"JawOpen", "TongueOut"}}};
  for (const auto& [of, missing] : lacking) {
    const auto targets = morph_targets(face, of);
    for (const std::string& name : missing) {
      const auto found = std::ranges::find(targets, name, &MorphTarget::name);
      ASSERT_NE(found, targets.end()) << name;
      EXPECT_TRUE(found->vertex.empty()) << name;
    }
  }
}

TEST(MorphTargets, TheirWeightIsTheMeanOfTheirShapes) {
  const auto targets = morph_targets(builtin(), TargetNames::arkit);
  const MorphTarget& inner = *std::ranges::find(targets, "browInnerUp", &MorphTarget::name);
  EXPECT_THAT(inner.shapes, ElementsAre(shape("browInnerUp_L"), shape("browInnerUp_R")));
  BlendshapeWeights weights;
  weights[shape("browInnerUp_L")] = 0.8F;
  weights[shape("browInnerUp_R")] = 0.4F;
  EXPECT_FLOAT_EQ(weight_of(inner, weights, 0), 0.6F);
  EXPECT_FLOAT_EQ(weight_of(*std::ranges::find(targets, "tongueOut", &MorphTarget::name), weights, 0.3F),
                  0.3F);
}

}  // namespace
}  // namespace mien::face::morph_targets_test
