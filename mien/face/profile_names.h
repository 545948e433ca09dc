#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

// Names of the outside world's shapes, each in its own order. What they are of ours: profiles/*.toml.
namespace mien::face {

/// ArkitOrder::live_link_udp, which is also the order of Apple's documentation topics.
inline constexpr std::size_t kArkitCount = 52;
inline constexpr std::array<std::string_view, kArkitCount> kArkitNames = {
    "eyeBlinkLeft",      "eyeLookDownLeft",    "eyeLookInLeft",
    "eyeLookOutLeft",    "eyeLookUpLeft",      "eyeSquintLeft",
    "eyeWideLeft",       "eyeBlinkRight",      "eyeLookDownRight",
    "eyeLookInRight",    "eyeLookOutRight",    "eyeLookUpRight",
    "eyeSquintRight",    "eyeWideRight",       "jawForward",
    "jawLeft",           "jawRight",           "jawOpen",
    "mouthClose",        "mouthFunnel",        "mouthPucker",
    "mouthLeft",         "mouthRight",         "mouthSmileLeft",
    "mouthSmileRight",   "mouthFrownLeft",     "mouthFrownRight",
    "mouthDimpleLeft",   "mouthDimpleRight",   "mouthStretchLeft",
    "mouthStretchRight", "mouthRollLower",     "mouthRollUpper",
    "mouthShrugLower",   "mouthShrugUpper",    "mouthPressLeft",
    "mouthPressRight",   "mouthLowerDownLeft", "mouthLowerDownRight",
    "mouthUpperUpLeft",  "mouthUpperUpRight",  "browDownLeft",
    "browDownRight",     "browInnerUp",        "browOuterUpLeft",
    "browOuterUpRight",  "cheekPuff",          "cheekSquintLeft",
    "cheekSquintRight",  "noseSneerLeft",      "noseSneerRight",
    "tongueOut"};

/// Unified Expressions' base shapes, in VRCFaceTracking's order.
inline constexpr std::size_t kUnifiedCount = 88;
inline constexpr std::array<std::string_view, kUnifiedCount> kUnifiedNames = {
    // Eyes and brows.
    "EyeSquintRight", "EyeSquintLeft", "EyeWideRight", "EyeWideLeft", "BrowPinchRight", "BrowPinchLeft",
    "BrowLowererRight", "BrowLowererLeft", "BrowInnerUpRight", "BrowInnerUpLeft", "BrowOuterUpRight",
    "BrowOuterUpLeft",
    // Nose and cheeks.
    "NasalDilationRight", "NasalDilationLeft", "NasalConstrictRight", "NasalConstrictLeft",
    "CheekSquintRight", "CheekSquintLeft", "CheekPuffRight", "CheekPuffLeft", "CheekSuckRight",
    "CheekSuckLeft",
    // Jaw.
    "JawOpen", "JawRight", "JawLeft", "JawForward", "JawBackward", "JawClench", "JawMandibleRaise",
    "MouthClosed",
    // Lips.
    "LipSuckUpperRight", "LipSuckUpperLeft", "LipSuckLowerRight", "LipSuckLowerLeft", "LipSuckCornerRight",
    "LipSuckCornerLeft", "LipFunnelUpperRight", "LipFunnelUpperLeft", "LipFunnelLowerRight",
    "LipFunnelLowerLeft", "LipPuckerUpperRight", "LipPuckerUpperLeft", "LipPuckerLowerRight",
    "LipPuckerLowerLeft",
    // Mouth and nose.
    "MouthUpperUpRight", "MouthUpperUpLeft", "MouthUpperDeepenRight", "MouthUpperDeepenLeft",
    "NoseSneerRight", "NoseSneerLeft", "MouthLowerDownRight", "MouthLowerDownLeft", "MouthUpperRight",
    "MouthUpperLeft", "MouthLowerRight", "MouthLowerLeft", "MouthCornerPullRight", "MouthCornerPullLeft",
    "MouthCornerSlantRight", "MouthCornerSlantLeft", "MouthFrownRight", "MouthFrownLeft", "MouthStretchRight",
    "MouthStretchLeft", "MouthDimpleRight", "MouthDimpleLeft", "MouthRaiserUpper", "MouthRaiserLower",
    "MouthPressRight", "MouthPressLeft", "MouthTightenerRight", "MouthTightenerLeft",
    // Tongue, throat and neck.
    "TongueOut", "TongueUp", "TongueDown", "TongueRight", "TongueLeft", "TongueRoll", "TongueBendDown",
    "TongueCurlUp", "TongueSquish", "TongueFlat", "TongueTwistRight", "TongueTwistLeft", "SoftPalateClose",
    "ThroatSwallow", "NeckFlexRight", "NeckFlexLeft"};

/// OpenXR's XR_FB_face_tracking2, in the order of its enumeration: XR_FACE_EXPRESSION2_NAME_FB. The first
/// 63 are XR_FB_face_tracking's.
inline constexpr std::size_t kOpenXrFbCount = 70;
inline constexpr std::size_t kOpenXrFbFirstCount = 63;
inline constexpr std::array<std::string_view, kOpenXrFbCount> kOpenXrFbNames = {
    // XR_FB_face_tracking.
    "BROW_LOWERER_L", "BROW_LOWERER_R", "CHEEK_PUFF_L", "CHEEK_PUFF_R", "CHEEK_RAISER_L", "CHEEK_RAISER_R",
    "CHEEK_SUCK_L", "CHEEK_SUCK_R", "CHIN_RAISER_B", "CHIN_RAISER_T", "DIMPLER_L", "DIMPLER_R",
    "EYES_CLOSED_L", "EYES_CLOSED_R", "EYES_LOOK_DOWN_L", "EYES_LOOK_DOWN_R", "EYES_LOOK_LEFT_L",
    "EYES_LOOK_LEFT_R", "EYES_LOOK_RIGHT_L", "EYES_LOOK_RIGHT_R", "EYES_LOOK_UP_L", "EYES_LOOK_UP_R",
    "INNER_BROW_RAISER_L", "INNER_BROW_RAISER_R", "JAW_DROP", "JAW_SIDEWAYS_LEFT", "JAW_SIDEWAYS_RIGHT",
    "JAW_THRUST", "LID_TIGHTENER_L", "LID_TIGHTENER_R", "LIP_CORNER_DEPRESSOR_L", "LIP_CORNER_DEPRESSOR_R",
    "LIP_CORNER_PULLER_L", "LIP_CORNER_PULLER_R", "LIP_FUNNELER_LB", "LIP_FUNNELER_LT", "LIP_FUNNELER_RB",
    "LIP_FUNNELER_RT", "LIP_PRESSOR_L", "LIP_PRESSOR_R", "LIP_PUCKER_L", "LIP_PUCKER_R", "LIP_STRETCHER_L",
    "LIP_STRETCHER_R", "LIP_SUCK_LB", "LIP_SUCK_LT", "LIP_SUCK_RB", "LIP_SUCK_RT", "LIP_TIGHTENER_L",
    "LIP_TIGHTENER_R", "LIPS_TOWARD", "LOWER_LIP_DEPRESSOR_L", "LOWER_LIP_DEPRESSOR_R", "MOUTH_LEFT",
    "MOUTH_RIGHT", "NOSE_WRINKLER_L", "NOSE_WRINKLER_R", "OUTER_BROW_RAISER_L", "OUTER_BROW_RAISER_R",
    "UPPER_LID_RAISER_L", "UPPER_LID_RAISER_R", "UPPER_LIP_RAISER_L", "UPPER_LIP_RAISER_R",
    // Of XR_FB_face_tracking2 alone.
    "TONGUE_TIP_INTERDENTAL", "TONGUE_TIP_ALVEOLAR", "TONGUE_FRONT_DORSAL_PALATE", "TONGUE_MID_DORSAL_PALATE",
    "TONGUE_BACK_DORSAL_VELAR", "TONGUE_OUT", "TONGUE_RETREAT"};

/// REFA's shapes. The seven groups and their counts are REFA's (CVPRW 2024, supplement); order, division and
/// which two of OpenXR's are not among them (LIP_TIGHTENER_L, LIP_TIGHTENER_R) are ours. Spelt as REFA spells
/// jawDrop and outerBrowRaiser_L: OpenXR's words; L, R the sides, B, T bottom and top.
inline constexpr std::size_t kRefaCount = 64;
inline constexpr std::array<std::string_view, kRefaCount> kRefaNames = {
    // Brow.
    "browLowerer_L", "browLowerer_R", "innerBrowRaiser_L", "innerBrowRaiser_R", "outerBrowRaiser_L",
    "outerBrowRaiser_R",
    // Eye.
    "eyesClosed_L", "eyesClosed_R", "lidTightener_L", "lidTightener_R", "upperLidRaiser_L",
    "upperLidRaiser_R", "eyesLookDown_L", "eyesLookDown_R", "eyesLookLeft_L", "eyesLookLeft_R",
    "eyesLookRight_L", "eyesLookRight_R", "eyesLookUp_L", "eyesLookUp_R",
    // Cheek.
    "cheekPuff_L", "cheekPuff_R", "cheekRaiser_L", "cheekRaiser_R", "cheekSuck_L", "cheekSuck_R",
    "noseWrinkler_L", "noseWrinkler_R",
    // Mouth.
    "mouthLeft", "mouthRight", "lipCornerPuller_L", "lipCornerPuller_R", "lipCornerDepressor_L",
    "lipCornerDepressor_R", "dimpler_L", "dimpler_R", "lipStretcher_L", "lipStretcher_R", "lipPucker_L",
    "lipPucker_R",
    // Upper lip.
    "upperLipRaiser_L", "upperLipRaiser_R", "lipFunneler_LT", "lipFunneler_RT", "lipSuck_LT", "lipSuck_RT",
    "lipsToward_LT", "lipsToward_RT", "lipPressor_L", "lipPressor_R", "chinRaiser_T",
    // Lower lip.
    "lowerLipDepressor_L", "lowerLipDepressor_R", "lipFunneler_LB", "lipFunneler_RB", "lipSuck_LB",
    "lipSuck_RB", "lipsToward_LB", "lipsToward_RB", "chinRaiser_B",
    // Jaw.
    "jawDrop", "jawSidewaysLeft", "jawSidewaysRight", "jawThrust"};

/// Neighbours in a profile that belong together.
struct ShapeGroup {
  std::string_view name;
  std::size_t count = 0;
};
inline constexpr std::array<ShapeGroup, 7> kRefaGroups = {
    {{"brow", 6}, {"eye", 14}, {"cheek", 8}, {"mouth", 12}, {"upper lip", 11}, {"lower lip", 9}, {"jaw", 4}}};

/// The profiles that have a table in profiles/.
enum class OutsideProfile : std::uint8_t { arkit52, openxr_fb_63, openxr_fb_70, refa_64, unified };

/// A profile's name, its shapes in order, and its groups, which follow each other and hold all; none where it
/// has none.
struct NamedShapes {
  std::string_view profile;
  std::span<const std::string_view> shapes;
  std::span<const ShapeGroup> groups;
};
/// In the order of OutsideProfile.
inline constexpr std::array<NamedShapes, 5> kOutsideShapes = {{
    {"arkit52", kArkitNames, {}},
    {"openxr_fb_63", std::span(kOpenXrFbNames).first(kOpenXrFbFirstCount), {}},
    {"openxr_fb_70", kOpenXrFbNames, {}},
    {"refa_64", kRefaNames, kRefaGroups},
    {"unified", kUnifiedNames, {}},
}};

}  // namespace mien::face
