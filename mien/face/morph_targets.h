#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/face/face.h"
#include "mien/face/profile.h"

namespace mien::face {

/// Whose names a receiver knows a face's morph targets by.
enum class TargetNames : std::uint8_t {
  ict,    ///< Ours: "browInnerUp_L", the face's own shapes.
  arkit,  ///< Apple's 52, letter for letter: "browInnerUp", "eyeBlinkLeft".
  /// Unified Expressions (VRCFaceTracking): "BrowInnerUpLeft", "EyeClosedLeft"; those that ARKit's shapes
  /// tell.
  unified,
};

/// A morph target made of one or several of a face's shapes, or of a portion of one.
struct MorphTarget {
  std::string name;
  /// Indices as in Face::shapes (kShapeCount is tongueOut); at least one. Its weight is the mean of theirs.
  std::vector<std::size_t> shapes;
  std::vector<std::uint32_t> vertex;  ///< Ascending.
  std::vector<Vec3f> delta_m;         ///< Displacement at weight 1, metres; beside `vertex`.
};

/// The morph targets of a face under those names, in the order of its profile. All of them are there; one of
/// a shape that the face lacks moves nothing. For ict they are the face's own shapes. With each at its
/// weight_of(), they displace a face as its shapes do, but for browInnerUp and cheekPuff of ARKit, which have
/// one weight for both sides.
///
/// Where Unified Expressions tell two motions or four portions of a shape apart, the targets add up to it: of
/// browDown three quarters lower and a quarter pinches, of mouthSmile 0.8 pull and 0.2 slant the corner (the
/// shares by which VRCFaceTracking weighs them in its own simpler parameters); lips are divided into left and
/// right at the midline (over 16 mm) and into upper and lower by how far the jaw carries them.
[[nodiscard]] std::vector<MorphTarget> morph_targets(const Face& face, TargetNames names);

/// What a target's weight is while the face has these.
[[nodiscard]] float weight_of(const MorphTarget& target, const BlendshapeWeights& weights, float tongue_out);

}  // namespace mien::face
