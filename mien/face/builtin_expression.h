#pragma once

#include <vector>

#include "mien/core/rotation.h"
#include "mien/face/builtin_mesh.h"

namespace mien::face::builtin {

/// Displacement of every vertex of the sculpted head at weight 1 (mm), in the order of kShapeNames and then
/// tongueOut. Right shapes are the mirror images of left ones.
[[nodiscard]] std::vector<std::vector<Vec3>> shape_displacements(const Sculpt& whole);

/// Adds to each shape smooth fields about the sites, so that the skin there turns and stretches as real skin
/// does (docs/builtin_face.md). `displacements` as from shape_displacements.
void tune_kinematics(const Sculpt& whole, std::vector<std::vector<Vec3>>& displacements);

}  // namespace mien::face::builtin
