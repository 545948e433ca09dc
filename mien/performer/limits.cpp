#include "mien/performer/limits.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mien::performer {

using face::shape;

namespace {

/// Two shapes that pull against each other, and the share of their overlap that cancels.
struct Opposites {
  std::size_t a;
  std::size_t b;
  float cancels;
};
constexpr Opposites kOpposites[] = {
    {shape("jawLeft"), shape("jawRight"), 0.95F},
    {shape("mouthLeft"), shape("mouthRight"), 0.95F},
    {shape("mouthSmile_L"), shape("mouthFrown_L"), 0.7F},
    {shape("mouthSmile_R"), shape("mouthFrown_R"), 0.7F},
    {shape("browDown_L"), shape("browOuterUp_L"), 0.6F},
    {shape("browDown_R"), shape("browOuterUp_R"), 0.6F},
    {shape("mouthPucker"), shape("mouthStretch_L"), 0.4F},
    {shape("mouthPucker"), shape("mouthStretch_R"), 0.4F},
    {shape("mouthPucker"), shape("mouthSmile_L"), 0.3F},
    {shape("mouthPucker"), shape("mouthSmile_R"), 0.3F},
    {shape("mouthFunnel"), shape("mouthRollLower"), 0.6F},
    {shape("mouthFunnel"), shape("mouthRollUpper"), 0.6F},
    {shape("mouthRollLower"), shape("mouthLowerDown_L"), 0.5F},
    {shape("mouthRollLower"), shape("mouthLowerDown_R"), 0.5F},
    {shape("mouthRollUpper"), shape("mouthUpperUp_L"), 0.5F},
    {shape("mouthRollUpper"), shape("mouthUpperUp_R"), 0.5F},
    {shape("eyeSquint_L"), shape("eyeWide_L"), 0.6F},
    {shape("eyeSquint_R"), shape("eyeWide_R"), 0.6F},
};

}  // namespace

float soft_ceiling(float weight) {
  constexpr float kKnee = 0.9F;
  if (weight <= 0) return 0;
  if (weight <= kKnee) return weight;
  constexpr float kRoom = kLargestWeight - kKnee;
  return kKnee + kRoom * std::tanh((weight - kKnee) / kRoom);
}

void apply_limits(face::BlendshapeWeights& weights, float lip_closure) {
  for (const Opposites& pair : kOpposites) {
    const float both = pair.cancels * std::min(weights[pair.a], weights[pair.b]);
    if (both <= 0) continue;
    weights[pair.a] -= both;
    weights[pair.b] -= both;
  }
  for (const auto& [blink, wide] : {std::pair{shape("eyeBlink_L"), shape("eyeWide_L")},
                                    std::pair{shape("eyeBlink_R"), shape("eyeWide_R")}})
    weights[wide] *= 1 - std::clamp(weights[blink], 0.0F, 1.0F);

  const float closure = std::clamp(lip_closure, 0.0F, 1.0F);
  float& jaw = weights[shape("jawOpen")];
  float& close = weights[shape("mouthClose")];
  // Lips reach each other over a jaw that is not far open.
  jaw -= closure * std::max(0.0F, jaw - 0.22F) * 0.7F;
  close = std::min(close, jaw);
  close += closure * (jaw - close);
  for (const std::size_t k : {shape("mouthLowerDown_L"), shape("mouthLowerDown_R"), shape("mouthUpperUp_L"),
                              shape("mouthUpperUp_R"), shape("mouthFunnel")})
    weights[k] *= 1 - 0.9F * closure;

  // An open mouth holds no air, and its lips are neither pressed nor rolled far.
  const float gap = std::clamp((jaw - close) / 0.5F, 0.0F, 1.0F);
  for (const std::size_t k :
       {shape("cheekPuff_L"), shape("cheekPuff_R"), shape("mouthPress_L"), shape("mouthPress_R")})
    weights[k] *= 1 - 0.7F * gap;

  for (float& weight : weights.values) weight = soft_ceiling(weight);
  close = std::min(close, jaw);
}

}  // namespace mien::performer
