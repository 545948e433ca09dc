#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/face/profile.h"

namespace mien::shaping {

/// How the streaming calibration treats a shape.
enum class RestingRule : std::uint8_t {
  none,  ///< Its usual value is no rest (jaw, what speech moves, gaze): left alone.
  rest,  ///< Its usual value is rest: rest is learnt, full stays 1.
  lids,  ///< Rest, and full from the blinks.
};

/// Shapes that are 0 most of the time, on most faces; what speech moves is not among them.
inline constexpr std::array<std::string_view, 26> kRestAtZero = {
    "browDown_L",  "browDown_R",  "browInnerUp_L", "browInnerUp_R", "browOuterUp_L",  "browOuterUp_R",
    "cheekPuff_L", "cheekPuff_R", "cheekSquint_L", "cheekSquint_R", "eyeSquint_L",    "eyeSquint_R",
    "eyeWide_L",   "eyeWide_R",   "mouthDimple_L", "mouthDimple_R", "mouthFrown_L",   "mouthFrown_R",
    "mouthLeft",   "mouthRight",  "mouthSmile_L",  "mouthSmile_R",  "mouthStretch_L", "mouthStretch_R",
    "noseSneer_L", "noseSneer_R"};
/// Shapes of closing lids, which blinks bring to their full.
inline constexpr std::array<std::string_view, 2> kLids = {"eyeBlink_L", "eyeBlink_R"};

/// One a shape, of the two tables.
inline constexpr std::array<RestingRule, face::kShapeCount> kRestingRules = [] {
  std::array<RestingRule, face::kShapeCount> rules{};
  for (const std::string_view name : kRestAtZero) rules.at(face::shape_index(name)) = RestingRule::rest;
  for (const std::string_view name : kLids) rules.at(face::shape_index(name)) = RestingRule::lids;
  return rules;
}();

/// What the streaming calibration has learnt of one wearer: the values that a tracker answers for the face at
/// rest and for lids fully closed. w' = (w - rest) / (full - rest), held to [0, 1]. Stored in calibration
/// versions; by default it changes nothing.
struct RestingFace {
  /// A shape whose usual value is above this is being performed, not at rest.
  static constexpr float kRestAtMost = 0.5F;
  /// Least full - rest: what a wearer does least is not exaggerated more than fourfold.
  static constexpr float kLeastRange = 0.25F;

  std::array<float, face::kShapeCount> rest{};                ///< 0 to kRestAtMost.
  std::array<float, face::kShapeCount> full = whole_range();  ///< rest + kLeastRange to 1; 1 but for lids.

  /// A tracker's weight as it is with this face at rest. Changes no bit where rest is 0 and full is 1.
  [[nodiscard]] float applied(std::size_t shape, float weight) const;
  [[nodiscard]] bool changes(std::size_t shape) const { return rest[shape] != 0 || full[shape] != 1; }
  /// Every value finite and in its range; 0 and 1 for shapes to which the calibration does not apply.
  [[nodiscard]] RestingFace within_range() const;
  bool operator==(const RestingFace&) const = default;

 private:
  static constexpr std::array<float, face::kShapeCount> whole_range() {
    std::array<float, face::kShapeCount> ones{};
    ones.fill(1);
    return ones;
  }
};

/// JSON, from which parse_resting_face restores an equal value: {"rest": {shape: weight}, "full": {shape:
/// weight}}; what changes nothing is left out.
[[nodiscard]] std::string write_resting_face(const RestingFace& face);
/// Errors: malformed (no JSON, unknown key or shape, a shape to which it does not apply, a value of another
/// type), out_of_range. `where` names the source in messages.
[[nodiscard]] Result<RestingFace> parse_resting_face(std::string_view json, const std::string& where);

}  // namespace mien::shaping
