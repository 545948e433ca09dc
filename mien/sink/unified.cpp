#include "mien/sink/unified.h"

#include <algorithm>
#include <cmath>

#include "mien/face/profile_map.h"

namespace mien::sink {
namespace {

using Frame = UnifiedFrame;

/// Index of a base shape; a name that there is not does not compile.
consteval std::size_t shape(std::string_view name) {
  std::size_t i = 0;
  while (i < kUnifiedCount && kUnifiedNames[i] != name) ++i;
  if (i == kUnifiedCount) throw "no such shape";
  return i;
}

/// A pair of base shapes by what comes before "Right" and "Left": the left one follows the right one.
struct Pair {
  std::size_t right = 0;
  consteval Pair(const char* name) {  // Implicit: a name that there is not does not compile.
    const std::string_view stem = name;
    const auto is = [stem](std::string_view shape, std::string_view side) {
      return shape.starts_with(stem) && shape.substr(stem.size()) == side;
    };
    while (!is(kUnifiedNames[right], "Right")) ++right;
    if (!is(kUnifiedNames[right + 1], "Left")) throw "no pair";
  }
};
float right(const Frame& f, Pair p) {
  return f.shapes[p.right];
}
float left(const Frame& f, Pair p) {
  return f.shapes[p.right + 1];
}
float mean(const Frame& f, Pair p) {
  return 0.5F * (right(f, p) + left(f, p));
}
float larger(const Frame& f, Pair p) {
  return std::max(right(f, p), left(f, p));
}

// One side of what is derived: +side is left() or right() of the pairs.
using Side = float (*)(const Frame&, Pair);
float brow_up(const Frame& f, Side side) {
  return 0.6F * side(f, "BrowOuterUp") + 0.4F * side(f, "BrowInnerUp");
}
float brow_down(const Frame& f, Side side) {
  return 0.75F * side(f, "BrowLowerer") + 0.25F * side(f, "BrowPinch");
}
float brow_expression(const Frame& f, Side side) {
  return std::min(1.0F, 0.5F * (side(f, "BrowInnerUp") + side(f, "BrowOuterUp"))) - brow_down(f, side);
}
float smile(const Frame& f, Side side) {
  return 0.8F * side(f, "MouthCornerPull") + 0.2F * side(f, "MouthCornerSlant");
}
float sad(const Frame& f, Side side) {
  return std::max(side(f, "MouthFrown"), side(f, "MouthStretch"));
}
float corner_y(const Frame& f, Side side) {
  return side(f, "MouthCornerSlant") - side(f, "MouthFrown");
}
float lid(const Frame& f, std::size_t eye) {
  return 0.75F * f.openness[eye] + 0.25F * (eye == 0 ? left : right)(f, "EyeWide");
}
float openness(const Frame& f) {
  return 0.5F * (f.openness[0] + f.openness[1]);
}
/// Nothing here sees a pupil: it stays halfway.
float pupil(const Frame& /*f*/) {
  return 0.5F;
}

/// The formulas are VRCFaceTracking's: avatars are made for them.
constexpr auto kDerived = std::to_array<UnifiedParameter>({
    // Eyes.
    {"EyeLeftX", [](const Frame& f) { return f.gaze[0][0]; }},
    {"EyeLeftY", [](const Frame& f) { return f.gaze[0][1]; }},
    {"EyeRightX", [](const Frame& f) { return f.gaze[1][0]; }},
    {"EyeRightY", [](const Frame& f) { return f.gaze[1][1]; }},
    {"EyeX", [](const Frame& f) { return 0.5F * (f.gaze[0][0] + f.gaze[1][0]); }},
    {"EyeY", [](const Frame& f) { return 0.5F * (f.gaze[0][1] + f.gaze[1][1]); }},
    {"EyeOpenLeft", [](const Frame& f) { return f.openness[0]; }},
    {"EyeOpenRight", [](const Frame& f) { return f.openness[1]; }},
    {"EyeOpen", openness},
    {"EyeClosedLeft", [](const Frame& f) { return 1 - f.openness[0]; }},
    {"EyeClosedRight", [](const Frame& f) { return 1 - f.openness[1]; }},
    {"EyeClosed", [](const Frame& f) { return 1 - openness(f); }},
    {"EyeLidLeft", [](const Frame& f) { return lid(f, 0); }},
    {"EyeLidRight", [](const Frame& f) { return lid(f, 1); }},
    {"EyeLid", [](const Frame& f) { return 0.5F * (lid(f, 0) + lid(f, 1)); }},
    {"EyeWide", [](const Frame& f) { return larger(f, "EyeWide"); }},
    {"EyeSquint", [](const Frame& f) { return larger(f, "EyeSquint"); }},
    {"EyesSquint", [](const Frame& f) { return larger(f, "EyeSquint"); }},
    {"PupilDilation", pupil},
    {"PupilDiameterLeft", pupil},
    {"PupilDiameterRight", pupil},
    {"PupilDiameter", pupil},
    // Brows.
    {"BrowUpRight", [](const Frame& f) { return brow_up(f, right); }},
    {"BrowUpLeft", [](const Frame& f) { return brow_up(f, left); }},
    {"BrowUp", [](const Frame& f) { return 0.5F * (brow_up(f, right) + brow_up(f, left)); }},
    {"BrowDownRight", [](const Frame& f) { return brow_down(f, right); }},
    {"BrowDownLeft", [](const Frame& f) { return brow_down(f, left); }},
    {"BrowDown", [](const Frame& f) { return 0.5F * (brow_down(f, right) + brow_down(f, left)); }},
    {"BrowInnerUp", [](const Frame& f) { return mean(f, "BrowInnerUp"); }},
    {"BrowOuterUp", [](const Frame& f) { return mean(f, "BrowOuterUp"); }},
    {"BrowExpressionRight", [](const Frame& f) { return brow_expression(f, right); }},
    {"BrowExpressionLeft", [](const Frame& f) { return brow_expression(f, left); }},
    {"BrowExpression",
     [](const Frame& f) { return 0.5F * (brow_expression(f, right) + brow_expression(f, left)); }},
    // Jaw and cheeks.
    {"JawX", [](const Frame& f) { return right(f, "Jaw") - left(f, "Jaw"); }},
    {"JawZ", [](const Frame& f) { return f.shapes[shape("JawForward")] - f.shapes[shape("JawBackward")]; }},
    {"CheekSquint", [](const Frame& f) { return mean(f, "CheekSquint"); }},
    {"CheekPuffSuckLeft", [](const Frame& f) { return left(f, "CheekPuff") - left(f, "CheekSuck"); }},
    {"CheekPuffSuckRight", [](const Frame& f) { return right(f, "CheekPuff") - right(f, "CheekSuck"); }},
    {"CheekPuffSuck", [](const Frame& f) { return mean(f, "CheekPuff") - mean(f, "CheekSuck"); }},
    {"CheekSuck", [](const Frame& f) { return mean(f, "CheekSuck"); }},
    // Lips.
    {"MouthUpperX", [](const Frame& f) { return right(f, "MouthUpper") - left(f, "MouthUpper"); }},
    {"MouthLowerX", [](const Frame& f) { return right(f, "MouthLower") - left(f, "MouthLower"); }},
    {"MouthX",
     [](const Frame& f) {
       return 0.5F * (right(f, "MouthUpper") + right(f, "MouthLower") - left(f, "MouthUpper") -
                      left(f, "MouthLower"));
     }},
    {"LipSuckUpper", [](const Frame& f) { return mean(f, "LipSuckUpper"); }},
    {"LipSuckLower", [](const Frame& f) { return mean(f, "LipSuckLower"); }},
    {"LipSuck", [](const Frame& f) { return 0.5F * (mean(f, "LipSuckUpper") + mean(f, "LipSuckLower")); }},
    {"LipFunnelUpper", [](const Frame& f) { return mean(f, "LipFunnelUpper"); }},
    {"LipFunnelLower", [](const Frame& f) { return mean(f, "LipFunnelLower"); }},
    {"LipFunnel", [](const Frame& f) { return 0.5F * (mean(f, "LipFunnelUpper") + mean(f, "LipFunnelLower")); }},
    {"LipPuckerUpper", [](const Frame& f) { return mean(f, "LipPuckerUpper"); }},
    {"LipPuckerLower", [](const Frame& f) { return mean(f, "LipPuckerLower"); }},
    {"LipPuckerLeft", [](const Frame& f) { return 0.5F * (left(f, "LipPuckerUpper") + left(f, "LipPuckerLower")); }},
    {"LipPuckerRight",
     [](const Frame& f) { return 0.5F * (right(f, "LipPuckerUpper") + right(f, "LipPuckerLower")); }},
    {"LipPucker", [](const Frame& f) { return 0.5F * (mean(f, "LipPuckerUpper") + mean(f, "LipPuckerLower")); }},
    {"LipSuckFunnelUpper", [](const Frame& f) { return mean(f, "LipSuckUpper") - mean(f, "LipFunnelUpper"); }},
    {"LipSuckFunnelUpperLeft", [](const Frame& f) { return left(f, "LipSuckUpper") - left(f, "LipFunnelUpper"); }},
    {"LipSuckFunnelUpperRight", [](const Frame& f) { return right(f, "LipSuckUpper") - right(f, "LipFunnelUpper"); }},
    {"LipSuckFunnelLower", [](const Frame& f) { return mean(f, "LipSuckLower") - mean(f, "LipFunnelLower"); }},
    {"LipSuckFunnelLowerLeft", [](const Frame& f) { return left(f, "LipSuckLower") - left(f, "LipFunnelLower"); }},
    {"LipSuckFunnelLowerRight", [](const Frame& f) { return right(f, "LipSuckLower") - right(f, "LipFunnelLower"); }},
    // Mouth.
    {"MouthUpperUp", [](const Frame& f) { return mean(f, "MouthUpperUp"); }},
    {"MouthLowerDown", [](const Frame& f) { return mean(f, "MouthLowerDown"); }},
    {"MouthOpen", [](const Frame& f) { return 0.5F * (mean(f, "MouthUpperUp") + mean(f, "MouthLowerDown")); }},
    {"MouthStretch", [](const Frame& f) { return mean(f, "MouthStretch"); }},
    {"MouthTightener", [](const Frame& f) { return mean(f, "MouthTightener"); }},
    {"MouthPress", [](const Frame& f) { return mean(f, "MouthPress"); }},
    {"MouthDimple", [](const Frame& f) { return mean(f, "MouthDimple"); }},
    {"NoseSneer", [](const Frame& f) { return mean(f, "NoseSneer"); }},
    {"MouthTightenerStretch", [](const Frame& f) { return mean(f, "MouthTightener") - mean(f, "MouthStretch"); }},
    {"MouthTightenerStretchLeft", [](const Frame& f) { return left(f, "MouthTightener") - left(f, "MouthStretch"); }},
    {"MouthTightenerStretchRight", [](const Frame& f) { return right(f, "MouthTightener") - right(f, "MouthStretch"); }},
    {"MouthCornerYLeft", [](const Frame& f) { return corner_y(f, left); }},
    {"MouthCornerYRight", [](const Frame& f) { return corner_y(f, right); }},
    {"MouthCornerY", [](const Frame& f) { return 0.5F * (corner_y(f, left) + corner_y(f, right)); }},
    {"MouthSmileRight", [](const Frame& f) { return smile(f, right); }},
    {"MouthSmileLeft", [](const Frame& f) { return smile(f, left); }},
    {"MouthSadRight", [](const Frame& f) { return sad(f, right); }},
    {"MouthSadLeft", [](const Frame& f) { return sad(f, left); }},
    {"SmileFrownRight", [](const Frame& f) { return smile(f, right) - right(f, "MouthFrown"); }},
    {"SmileFrownLeft", [](const Frame& f) { return smile(f, left) - left(f, "MouthFrown"); }},
    {"SmileFrown", [](const Frame& f) { return 0.5F * (smile(f, right) + smile(f, left)) - mean(f, "MouthFrown"); }},
    {"SmileSadRight", [](const Frame& f) { return smile(f, right) - sad(f, right); }},
    {"SmileSadLeft", [](const Frame& f) { return smile(f, left) - sad(f, left); }},
    {"SmileSad",
     [](const Frame& f) { return 0.5F * (smile(f, right) + smile(f, left) - sad(f, right) - sad(f, left)); }},
    // Tongue.
    {"TongueX", [](const Frame& f) { return right(f, "Tongue") - left(f, "Tongue"); }},
    {"TongueY", [](const Frame& f) { return f.shapes[shape("TongueUp")] - f.shapes[shape("TongueDown")]; }},
    {"TongueArchY",
     [](const Frame& f) { return f.shapes[shape("TongueCurlUp")] - f.shapes[shape("TongueBendDown")]; }},
    {"TongueShape",
     [](const Frame& f) { return f.shapes[shape("TongueFlat")] - f.shapes[shape("TongueSquish")]; }},
});

constexpr auto kUnifiedParameters = [] {
  std::array<UnifiedParameter, kUnifiedCount + kDerived.size()> all;
  for (std::size_t i = 0; i < kUnifiedCount; ++i) all[i] = {kUnifiedNames[i], nullptr, i};
  std::ranges::copy(kDerived, all.begin() + kUnifiedCount);
  return all;
}();

}  // namespace

UnifiedFrame unified_frame(const ArkitFrame& frame) {
  UnifiedFrame unified;
  float tongue_out = 0;
  const face::BlendshapeWeights weights = face::ict_from_arkit(frame.weights, &tongue_out);
  face::profile_map(face::OutsideProfile::unified).from_ict(weights, tongue_out, unified.shapes);
  const std::array<float, 2> blink = {weights[face::shape("eyeBlink_L")], weights[face::shape("eyeBlink_R")]};
  const std::array<float, 2> squint = {weights[face::shape("eyeSquint_L")],
                                       weights[face::shape("eyeSquint_R")]};
  for (std::size_t eye = 0; eye < 2; ++eye) {
    unified.openness[eye] = 1 - std::min(1.0F, blink[eye] * (1 + squint[eye]));
    for (int k = 0; k < 2; ++k) {
      const float tangent = std::clamp(std::tan(frame.eyes_rad[eye][k]), -1.0F, 1.0F);
      unified.gaze[eye][static_cast<std::size_t>(k)] = k == 0 ? 0.0F - tangent : tangent;
    }
  }
  return unified;
}

std::span<const UnifiedParameter> unified_parameters() {
  return kUnifiedParameters;
}

}  // namespace mien::sink
