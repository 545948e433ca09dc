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

/// A pair of base shapes, by the right one's index: the left one follows it.
struct Pair {
  std::size_t right;
  consteval explicit Pair(std::size_t right_shape) : right(right_shape) {
    if (!kUnifiedNames[right].ends_with("Right") || !kUnifiedNames[right + 1].ends_with("Left"))
      throw "no pair";
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

constexpr Pair kEyeSquint{shape("EyeSquintRight")};
constexpr Pair kEyeWide{shape("EyeWideRight")};
constexpr Pair kBrowPinch{shape("BrowPinchRight")};
constexpr Pair kBrowLowerer{shape("BrowLowererRight")};
constexpr Pair kBrowInnerUp{shape("BrowInnerUpRight")};
constexpr Pair kBrowOuterUp{shape("BrowOuterUpRight")};
constexpr Pair kCheekSquint{shape("CheekSquintRight")};
constexpr Pair kCheekPuff{shape("CheekPuffRight")};
constexpr Pair kCheekSuck{shape("CheekSuckRight")};
constexpr Pair kJaw{shape("JawRight")};
constexpr Pair kSuckUpper{shape("LipSuckUpperRight")};
constexpr Pair kSuckLower{shape("LipSuckLowerRight")};
constexpr Pair kFunnelUpper{shape("LipFunnelUpperRight")};
constexpr Pair kFunnelLower{shape("LipFunnelLowerRight")};
constexpr Pair kPuckerUpper{shape("LipPuckerUpperRight")};
constexpr Pair kPuckerLower{shape("LipPuckerLowerRight")};
constexpr Pair kUpperUp{shape("MouthUpperUpRight")};
constexpr Pair kNoseSneer{shape("NoseSneerRight")};
constexpr Pair kLowerDown{shape("MouthLowerDownRight")};
constexpr Pair kMouthUpper{shape("MouthUpperRight")};
constexpr Pair kMouthLower{shape("MouthLowerRight")};
constexpr Pair kCornerPull{shape("MouthCornerPullRight")};
constexpr Pair kCornerSlant{shape("MouthCornerSlantRight")};
constexpr Pair kFrown{shape("MouthFrownRight")};
constexpr Pair kStretch{shape("MouthStretchRight")};
constexpr Pair kDimple{shape("MouthDimpleRight")};
constexpr Pair kPress{shape("MouthPressRight")};
constexpr Pair kTightener{shape("MouthTightenerRight")};
constexpr Pair kTongue{shape("TongueRight")};

// One side of what is derived: +side is left() or right() of the pairs.
using Side = float (*)(const Frame&, Pair);
float brow_up(const Frame& f, Side side) {
  return 0.6F * side(f, kBrowOuterUp) + 0.4F * side(f, kBrowInnerUp);
}
float brow_down(const Frame& f, Side side) {
  return 0.75F * side(f, kBrowLowerer) + 0.25F * side(f, kBrowPinch);
}
float brow_expression(const Frame& f, Side side) {
  return std::min(1.0F, 0.5F * (side(f, kBrowInnerUp) + side(f, kBrowOuterUp))) - brow_down(f, side);
}
float smile(const Frame& f, Side side) {
  return 0.8F * side(f, kCornerPull) + 0.2F * side(f, kCornerSlant);
}
float sad(const Frame& f, Side side) {
  return std::max(side(f, kFrown), side(f, kStretch));
}
float corner_y(const Frame& f, Side side) {
  return side(f, kCornerSlant) - side(f, kFrown);
}
float lid(const Frame& f, std::size_t eye) {
  return 0.75F * f.openness[eye] + 0.25F * (eye == 0 ? left : right)(f, kEyeWide);
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
    {"EyeWide", [](const Frame& f) { return larger(f, kEyeWide); }},
    {"EyeSquint", [](const Frame& f) { return larger(f, kEyeSquint); }},
    {"EyesSquint", [](const Frame& f) { return larger(f, kEyeSquint); }},
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
    {"BrowInnerUp", [](const Frame& f) { return mean(f, kBrowInnerUp); }},
    {"BrowOuterUp", [](const Frame& f) { return mean(f, kBrowOuterUp); }},
    {"BrowExpressionRight", [](const Frame& f) { return brow_expression(f, right); }},
    {"BrowExpressionLeft", [](const Frame& f) { return brow_expression(f, left); }},
    {"BrowExpression",
     [](const Frame& f) { return 0.5F * (brow_expression(f, right) + brow_expression(f, left)); }},
    // Jaw and cheeks.
    {"JawX", [](const Frame& f) { return right(f, kJaw) - left(f, kJaw); }},
    {"JawZ", [](const Frame& f) { return f.shapes[shape("JawForward")] - f.shapes[shape("JawBackward")]; }},
    {"CheekSquint", [](const Frame& f) { return mean(f, kCheekSquint); }},
    {"CheekPuffSuckLeft", [](const Frame& f) { return left(f, kCheekPuff) - left(f, kCheekSuck); }},
    {"CheekPuffSuckRight", [](const Frame& f) { return right(f, kCheekPuff) - right(f, kCheekSuck); }},
    {"CheekPuffSuck", [](const Frame& f) { return mean(f, kCheekPuff) - mean(f, kCheekSuck); }},
    {"CheekSuck", [](const Frame& f) { return mean(f, kCheekSuck); }},
    // Lips.
    {"MouthUpperX", [](const Frame& f) { return right(f, kMouthUpper) - left(f, kMouthUpper); }},
    {"MouthLowerX", [](const Frame& f) { return right(f, kMouthLower) - left(f, kMouthLower); }},
    {"MouthX",
     [](const Frame& f) {
       return 0.5F * (right(f, kMouthUpper) + right(f, kMouthLower) - left(f, kMouthUpper) -
                      left(f, kMouthLower));
     }},
    {"LipSuckUpper", [](const Frame& f) { return mean(f, kSuckUpper); }},
    {"LipSuckLower", [](const Frame& f) { return mean(f, kSuckLower); }},
    {"LipSuck", [](const Frame& f) { return 0.5F * (mean(f, kSuckUpper) + mean(f, kSuckLower)); }},
    {"LipFunnelUpper", [](const Frame& f) { return mean(f, kFunnelUpper); }},
    {"LipFunnelLower", [](const Frame& f) { return mean(f, kFunnelLower); }},
    {"LipFunnel", [](const Frame& f) { return 0.5F * (mean(f, kFunnelUpper) + mean(f, kFunnelLower)); }},
    {"LipPuckerUpper", [](const Frame& f) { return mean(f, kPuckerUpper); }},
    {"LipPuckerLower", [](const Frame& f) { return mean(f, kPuckerLower); }},
    {"LipPuckerLeft", [](const Frame& f) { return 0.5F * (left(f, kPuckerUpper) + left(f, kPuckerLower)); }},
    {"LipPuckerRight",
     [](const Frame& f) { return 0.5F * (right(f, kPuckerUpper) + right(f, kPuckerLower)); }},
    {"LipPucker", [](const Frame& f) { return 0.5F * (mean(f, kPuckerUpper) + mean(f, kPuckerLower)); }},
    {"LipSuckFunnelUpper", [](const Frame& f) { return mean(f, kSuckUpper) - mean(f, kFunnelUpper); }},
    {"LipSuckFunnelUpperLeft", [](const Frame& f) { return left(f, kSuckUpper) - left(f, kFunnelUpper); }},
    {"LipSuckFunnelUpperRight", [](const Frame& f) { return right(f, kSuckUpper) - right(f, kFunnelUpper); }},
    {"LipSuckFunnelLower", [](const Frame& f) { return mean(f, kSuckLower) - mean(f, kFunnelLower); }},
    {"LipSuckFunnelLowerLeft", [](const Frame& f) { return left(f, kSuckLower) - left(f, kFunnelLower); }},
    {"LipSuckFunnelLowerRight", [](const Frame& f) { return right(f, kSuckLower) - right(f, kFunnelLower); }},
    // Mouth.
    {"MouthUpperUp", [](const Frame& f) { return mean(f, kUpperUp); }},
    {"MouthLowerDown", [](const Frame& f) { return mean(f, kLowerDown); }},
    {"MouthOpen", [](const Frame& f) { return 0.5F * (mean(f, kUpperUp) + mean(f, kLowerDown)); }},
    {"MouthStretch", [](const Frame& f) { return mean(f, kStretch); }},
    {"MouthTightener", [](const Frame& f) { return mean(f, kTightener); }},
    {"MouthPress", [](const Frame& f) { return mean(f, kPress); }},
    {"MouthDimple", [](const Frame& f) { return mean(f, kDimple); }},
    {"NoseSneer", [](const Frame& f) { return mean(f, kNoseSneer); }},
    {"MouthTightenerStretch", [](const Frame& f) { return mean(f, kTightener) - mean(f, kStretch); }},
    {"MouthTightenerStretchLeft", [](const Frame& f) { return left(f, kTightener) - left(f, kStretch); }},
    {"MouthTightenerStretchRight", [](const Frame& f) { return right(f, kTightener) - right(f, kStretch); }},
    {"MouthCornerYLeft", [](const Frame& f) { return corner_y(f, left); }},
    {"MouthCornerYRight", [](const Frame& f) { return corner_y(f, right); }},
    {"MouthCornerY", [](const Frame& f) { return 0.5F * (corner_y(f, left) + corner_y(f, right)); }},
    {"MouthSmileRight", [](const Frame& f) { return smile(f, right); }},
    {"MouthSmileLeft", [](const Frame& f) { return smile(f, left); }},
    {"MouthSadRight", [](const Frame& f) { return sad(f, right); }},
    {"MouthSadLeft", [](const Frame& f) { return sad(f, left); }},
    {"SmileFrownRight", [](const Frame& f) { return smile(f, right) - right(f, kFrown); }},
    {"SmileFrownLeft", [](const Frame& f) { return smile(f, left) - left(f, kFrown); }},
    {"SmileFrown", [](const Frame& f) { return 0.5F * (smile(f, right) + smile(f, left)) - mean(f, kFrown); }},
    {"SmileSadRight", [](const Frame& f) { return smile(f, right) - sad(f, right); }},
    {"SmileSadLeft", [](const Frame& f) { return smile(f, left) - sad(f, left); }},
    {"SmileSad",
     [](const Frame& f) { return 0.5F * (smile(f, right) + smile(f, left) - sad(f, right) - sad(f, left)); }},
    // Tongue.
    {"TongueX", [](const Frame& f) { return right(f, kTongue) - left(f, kTongue); }},
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
