#pragma once

#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "mien/core/error.h"
#include "mien/face/face.h"
#include "mien/face/morph_targets.h"

// What makes a glTF asset of a head an avatar by VRM 1.0 (VRM Consortium, VRMC_vrm 1.0).
namespace mien::render {

/// What of a file by VRM is a head at most, along any axis: more has a body of its own.
inline constexpr float kLargestHead_m = 0.7F;

/// The point of a face that an avatar's head turns about: the origin of frame H of those that are in it, the
/// middle of the box around others, wherever in a scene they stood. Errors: bad_usage (larger than
/// kLargestHead_m).
[[nodiscard]] Result<Vec3f> head_origin_m(const face::Face& face);

struct Skeleton {
  std::size_t root = 0;          ///< Its node, on the ground between the feet.
  Vec3f head_m = Vec3f::Zero();  ///< The head's place on the neck, m: +X the avatar's left, +Y up.
  nlohmann::json humanoid;       ///< The extension's part that names the bones' nodes.
};

/// Appends nodes to an asset's: the bones that a humanoid must have, in a T-pose. No vertex hangs on them but
/// the head's; `head`, the node that has them, gets its place on the neck.
[[nodiscard]] Skeleton add_skeleton(nlohmann::json& nodes, std::size_t head,
                                    const std::array<std::optional<std::size_t>, 2>& eyes);

/// The extension VRMC_vrm of an asset with morph targets under ARKit's names on the mesh of node `mesh`: the
/// humanoid, ARKit's 52 as expressions of its own ("JawOpen"), VRM's presets as sums of them, and whereby it
/// looks: its eyes' bones where it has both, else the eyelids' and eyes' shapes. `origin_m`: head_origin_m().
/// A built-in face has its authors' licence in it: everybody may wear, change, sell and pass it on. Of others
/// nothing is known, so what VRM does not permit by itself is not permitted.
[[nodiscard]] nlohmann::json vrm_extension(const face::Face& face, const Vec3f& origin_m,
                                           std::span<const face::MorphTarget> targets, std::size_t mesh,
                                           bool eyes_turn, nlohmann::json humanoid);

}  // namespace mien::render
