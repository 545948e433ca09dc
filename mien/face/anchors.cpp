#include "mien/face/anchors.h"

#include <cstdlib>
#include <initializer_list>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/face/target_names.h"

namespace mien::face {
namespace {

using Names = std::initializer_list<std::string_view>;

/// The shapes of these names in full, and of `halves` half; a name without a side stands for both.
BlendshapeWeights whole(Names names, Names halves = {}) {
  BlendshapeWeights weights;
  for (const auto& [given, weight] : {std::pair(names, 1.0F), std::pair(halves, 0.5F)})
    for (const std::string_view name : given) {
      const std::vector<std::size_t> shapes = shapes_named(name);
      if (shapes.empty()) std::abort();  // A typing error in the table below.
      for (const std::size_t shape : shapes) weights[shape] = weight;
    }
  return weights;
}

}  // namespace

std::span<const Anchor> anchors() {
  static const std::array kAnchors = {
      Anchor{"smile", "Smile as wide as you can", whole({"mouthSmile"})},
      Anchor{"brows_up", "Raise your eyebrows", whole({"browInnerUp", "browOuterUp"})},
      Anchor{"brows_down", "Frown with your eyebrows", whole({"browDown"})},
      Anchor{"eyes_shut", "Shut your eyes", whole({"eyeBlink"}, {"eyeSquint"})},
      Anchor{"cheek_puff", "Puff your cheeks", whole({"cheekPuff"})},
      Anchor{"jaw_open", "Open your mouth wide", whole({"jawOpen"})},
      Anchor{"pucker", "Pucker your lips, as for a kiss", whole({"mouthPucker"})},
      Anchor{"sneer", "Wrinkle your nose", whole({"noseSneer"})},
      Anchor{"frown", "Pull the corners of your mouth down", whole({"mouthFrown"})},
      Anchor{"mouth_left", "Move your mouth to your left", whole({"mouthLeft"})},
      Anchor{"mouth_right", "Move your mouth to your right", whole({"mouthRight"})},
  };
  return kAnchors;
}

std::span<const Anchor> range_of_motion() {
  static const std::array kRange = {
      Anchor{"browInnerUp", "Raise your inner eyebrows, as if worried", whole({"browInnerUp"})},
      Anchor{"browOuterUp", "Raise your outer eyebrows", whole({"browOuterUp"})},
      Anchor{"browOuterUp_L", "Raise your left eyebrow", whole({"browOuterUp_L"})},
      Anchor{"browOuterUp_R", "Raise your right eyebrow", whole({"browOuterUp_R"})},
      Anchor{"browDown", "Frown with your eyebrows", whole({"browDown"})},
      Anchor{"eyeWide", "Open your eyes wide", whole({"eyeWide"})},
      Anchor{"eyeSquint", "Squint", whole({"eyeSquint"})},
      Anchor{"eyeBlink", "Close your eyes gently", whole({"eyeBlink"})},
      Anchor{"cheekSquint", "Lift your cheeks towards your eyes", whole({"cheekSquint"})},
      Anchor{"cheekPuff", "Puff your cheeks", whole({"cheekPuff"})},
      Anchor{"noseSneer", "Wrinkle your nose", whole({"noseSneer"})},
      Anchor{"jawOpen", "Open your mouth wide", whole({"jawOpen"})},
      Anchor{"jawLeft", "Move your jaw to your left", whole({"jawLeft"})},
      Anchor{"jawRight", "Move your jaw to your right", whole({"jawRight"})},
      Anchor{"jawForward", "Push your jaw forward", whole({"jawForward"})},
      Anchor{"mouthSmile", "Smile as wide as you can", whole({"mouthSmile"})},
      Anchor{"mouthSmile_L", "Smile with the left corner of your mouth", whole({"mouthSmile_L"})},
      Anchor{"mouthSmile_R", "Smile with the right corner of your mouth", whole({"mouthSmile_R"})},
      Anchor{"mouthFrown", "Pull the corners of your mouth down", whole({"mouthFrown"})},
      Anchor{"mouthPucker", "Pucker your lips, as for a kiss", whole({"mouthPucker"})},
      Anchor{"mouthFunnel", "Round your lips, as for an \"oh\"", whole({"mouthFunnel"})},
      Anchor{"mouthLeft", "Move your mouth to your left", whole({"mouthLeft"})},
      Anchor{"mouthRight", "Move your mouth to your right", whole({"mouthRight"})},
      Anchor{"mouthStretch", "Pull the corners of your mouth apart", whole({"mouthStretch"})},
      Anchor{"mouthDimple", "Press the corners of your mouth in", whole({"mouthDimple"})},
      Anchor{"mouthPress", "Press your lips together", whole({"mouthPress"})},
      // Rolled lips roll together.
      Anchor{"mouthRoll", "Roll both lips inwards", whole({"mouthRollLower", "mouthRollUpper"})},
      Anchor{"mouthShrugLower", "Push your lower lip up", whole({"mouthShrugLower"})},
      Anchor{"mouthUpperUp", "Raise your upper lip and show your teeth", whole({"mouthUpperUp"})},
      Anchor{"mouthLowerDown", "Lower your lower lip and show your teeth", whole({"mouthLowerDown"})},
  };
  return kRange;
}

}  // namespace mien::face
