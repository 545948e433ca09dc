#include "lab/eyewear/sensors_tests.h"

#include <array>

#include "mien/performer/expression.h"

namespace mien::lab {
namespace {

using face::BlendshapeWeights;

BlendshapeWeights weights_of(const performer::Pose& pose) {
  BlendshapeWeights weights;
  for (const performer::PosePart& part : pose) weights[part.shape] = part.weight;
  return weights;
}

/// Expressions that one side alone makes; the paper shows some and lists none.
std::array<performer::Pose, 6> asymmetric_poses() {
  return {performer::pose_of({{"mouthSmile_L", 0.85F}, {"cheekSquint_L", 0.5F}, {"mouthDimple_L", 0.2F}}),
          performer::pose_of({{"browOuterUp_R", 0.8F}, {"browInnerUp_R", 0.5F}, {"browDown_L", 0.6F}}),
          performer::pose_of({{"eyeBlink_L", 1.0F}, {"cheekSquint_L", 0.6F}, {"mouthSmile_L", 0.3F}}),
          performer::pose_of({{"mouthLeft", 0.8F}, {"mouthPucker", 0.3F}}),
          performer::pose_of({{"jawRight", 0.7F}, {"jawOpen", 0.25F}, {"mouthRight", 0.3F}}),
          performer::pose_of({{"noseSneer_R", 0.8F}, {"mouthUpperUp_R", 0.7F}, {"cheekSquint_R", 0.4F}})};
}

}  // namespace

std::string_view sensors_test_set_name(SensorsTestSet set) {
  constexpr std::array<std::string_view, kTestSets> kNames = {"neutral", "A", "B", "C"};
  return kNames[static_cast<std::size_t>(set)];
}

std::vector<SensorsTest> make_sensors_tests(const virt::MarkerPoses& poses, Random random) {
  std::vector<SensorsTest> tests = {{SensorsTestSet::neutral, {}}};
  for (int i = 0; i < 6; ++i) tests.push_back({SensorsTestSet::components, poses.draw(random)});
  for (const performer::Emotion emotion :
       {performer::Emotion::joy, performer::Emotion::disgust, performer::Emotion::anger,
        performer::Emotion::surprise, performer::Emotion::fear, performer::Emotion::sadness})
    tests.push_back({SensorsTestSet::universal, weights_of(performer::emotion_expression(emotion).pose)});
  for (const performer::Pose& pose : asymmetric_poses())
    tests.push_back({SensorsTestSet::asymmetric, weights_of(pose)});
  return tests;
}

}  // namespace mien::lab
