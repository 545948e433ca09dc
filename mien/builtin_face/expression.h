#pragma once

#include <vector>

#include "mien/builtin_face/mesh.h"
#include "mien/core/rotation.h"

namespace mien::builtin_face {

/// Displacement of every vertex of the sculpted head at weight 1 (mm), in the order of kShapeNames and then
/// tongueOut. Right shapes are the mirror images of left ones.
[[nodiscard]] std::vector<std::vector<Vec3>> shape_displacements(const Sculpt& whole);

/// Adds to each shape smooth fields about the sites, so that the skin there turns and stretches as real skin
/// does (docs/method/builtin_face.md). `displacements` as from shape_displacements.
void tune_kinematics(const Sculpt& whole, std::vector<std::vector<Vec3>>& displacements);

/// Lips and the mouth's lining are never pressed into the teeth when a shape that leaves the jaw is full on.
void keep_off_teeth(const Sculpt& whole, std::vector<std::vector<Vec3>>& displacements);

}  // namespace mien::builtin_face
