#include "mien/face/anchors.h"

#include <initializer_list>
#include <utility>

namespace mien::face {
namespace {

BlendshapeWeights pose(std::initializer_list<std::pair<std::size_t, float>> parts) {
  BlendshapeWeights weights;
  for (const auto& [shape, weight] : parts) weights[shape] = weight;
  return weights;
}

}  // namespace

std::span<const Anchor> anchors() {
  static const std::array kAnchors = {
      Anchor{"smile", "Smile as wide as you can",
             pose({{shape("mouthSmile_L"), 1}, {shape("mouthSmile_R"), 1}})},
      Anchor{"brows_up", "Raise your eyebrows",
             pose({{shape("browInnerUp_L"), 1},
                   {shape("browInnerUp_R"), 1},
                   {shape("browOuterUp_L"), 1},
                   {shape("browOuterUp_R"), 1}})},
      Anchor{"brows_down", "Frown with your eyebrows",
             pose({{shape("browDown_L"), 1}, {shape("browDown_R"), 1}})},
      Anchor{"eyes_shut", "Shut your eyes",
             pose({{shape("eyeBlink_L"), 1},
                   {shape("eyeBlink_R"), 1},
                   {shape("eyeSquint_L"), 0.5F},
                   {shape("eyeSquint_R"), 0.5F}})},
      Anchor{"cheek_puff", "Puff your cheeks", pose({{shape("cheekPuff_L"), 1}, {shape("cheekPuff_R"), 1}})},
      Anchor{"jaw_open", "Open your mouth wide", pose({{shape("jawOpen"), 1}})},
      Anchor{"pucker", "Pucker your lips, as for a kiss", pose({{shape("mouthPucker"), 1}})},
      Anchor{"sneer", "Wrinkle your nose", pose({{shape("noseSneer_L"), 1}, {shape("noseSneer_R"), 1}})},
      Anchor{"frown", "Pull the corners of your mouth down",
             pose({{shape("mouthFrown_L"), 1}, {shape("mouthFrown_R"), 1}})},
      Anchor{"mouth_left", "Move your mouth to your left", pose({{shape("mouthLeft"), 1}})},
      Anchor{"mouth_right", "Move your mouth to your right", pose({{shape("mouthRight"), 1}})},
  };
  return kAnchors;
}

}  // namespace mien::face
