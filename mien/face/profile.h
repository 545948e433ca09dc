#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace mien::face {

/// How far an eye turns per unit of an eyeLook shape, rad: 35 degrees, as Live Link Face records it.
/// ICT-FaceKit's eyes turn so too.
inline constexpr double kEyeTurnRadPerUnit = 0.611;

/// Number of shapes inside: the ICT 53.
inline constexpr std::size_t kShapeCount = 53;

/// The inner profile: ICT-FaceKit's order and names. Left and right are the performer's own.
inline constexpr std::array<std::string_view, kShapeCount> kShapeNames = {
    "browDown_L",       "browDown_R",       "browInnerUp_L",  "browInnerUp_R",   "browOuterUp_L",
    "browOuterUp_R",    "cheekPuff_L",      "cheekPuff_R",    "cheekSquint_L",   "cheekSquint_R",
    "eyeBlink_L",       "eyeBlink_R",       "eyeLookDown_L",  "eyeLookDown_R",   "eyeLookIn_L",
    "eyeLookIn_R",      "eyeLookOut_L",     "eyeLookOut_R",   "eyeLookUp_L",     "eyeLookUp_R",
    "eyeSquint_L",      "eyeSquint_R",      "eyeWide_L",      "eyeWide_R",       "jawForward",
    "jawLeft",          "jawOpen",          "jawRight",       "mouthClose",      "mouthDimple_L",
    "mouthDimple_R",    "mouthFrown_L",     "mouthFrown_R",   "mouthFunnel",     "mouthLeft",
    "mouthLowerDown_L", "mouthLowerDown_R", "mouthPress_L",   "mouthPress_R",    "mouthPucker",
    "mouthRight",       "mouthRollLower",   "mouthRollUpper", "mouthShrugLower", "mouthShrugUpper",
    "mouthSmile_L",     "mouthSmile_R",     "mouthStretch_L", "mouthStretch_R",  "mouthUpperUp_L",
    "mouthUpperUp_R",   "noseSneer_L",      "noseSneer_R"};

/// Index of a shape in the inner profile; kShapeCount when there is none. `constexpr` so that code can name
/// shapes: `weights[shape("jawOpen")]`.
[[nodiscard]] constexpr std::size_t shape_index(std::string_view name) {
  std::size_t i = 0;
  while (i < kShapeCount && kShapeNames[i] != name) ++i;
  return i;
}
/// The same for names known at compile time: a misspelt one does not compile.
[[nodiscard]] consteval std::size_t shape(std::string_view name) {
  const std::size_t i = shape_index(name);
  if (i == kShapeCount) throw "no such shape";
  return i;
}

/// One weight a shape, in the order of kShapeNames; nominally 0 to 1, real performances go a little beyond.
struct BlendshapeWeights {
  std::array<float, kShapeCount> values{};

  float& operator[](std::size_t i) { return values[i]; }
  float operator[](std::size_t i) const { return values[i]; }
  bool operator==(const BlendshapeWeights&) const = default;
};

/// A named, ordered shape set of the outside world.
struct Profile {
  std::string name;
  std::vector<std::string> shapes;
};

/// The orders in which ARKit's 52 names are met (Unreal, iFacialMocap, alphabetical and others, beside
/// Apple's own).
enum class ArkitOrder {
  live_link_udp,        ///< Apple's documentation topics; Live Link Face UDP.
  live_link_csv,        ///< jawRight before jawLeft, mouthRight before mouthLeft.
  live_link_csv_right,  ///< The newer CSV: right side first.
  alphabetical,         ///< SDK header, Unity.
  vts,                  ///< VTube Studio: UDP order with jawRight before jawLeft.
};

[[nodiscard]] const Profile& ict53();
/// Names as ARKit spells them: "eyeBlinkLeft".
[[nodiscard]] const Profile& arkit52(ArkitOrder order = ArkitOrder::live_link_udp);
/// `_neutral` first, no tongueOut.
[[nodiscard]] const Profile& mediapipe52();

/// One time instant in ARKit's terms: name-keyed edges meet here.
struct ArkitWeights {
  std::array<float, 52> values{};  ///< In ArkitOrder::live_link_udp.
};

/// Index of an ARKit name in live_link_udp order, case-insensitive, `_L`/`_R` suffixes accepted; 52 when
/// unknown.
[[nodiscard]] std::size_t arkit_index(std::string_view name);

/// ARKit to ICT: browInnerUp and cheekPuff go to both sides; tongueOut has no shape and is returned beside.
[[nodiscard]] BlendshapeWeights ict_from_arkit(const ArkitWeights& arkit, float* tongue_out = nullptr);
/// ICT to ARKit: browInnerUp and cheekPuff are the mean of both sides; mouthClose is held to <= jawOpen when
/// `clamp_mouth_close` (it is a corrective of jawOpen, and receivers break otherwise).
[[nodiscard]] ArkitWeights arkit_from_ict(const BlendshapeWeights& ict, float tongue_out,
                                          bool clamp_mouth_close);

}  // namespace mien::face
