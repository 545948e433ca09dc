#pragma once

#include <functional>
#include <span>
#include <vector>

#include "mien/builtin_face/mesh.h"
#include "mien/core/rotation.h"

namespace mien::builtin_face {

/// Takes the displacement of every vertex by one shape at weight 1, mm; `shape` as kShapeNames has it, or
/// kShapeCount for tongueOut.
using TakeShape = std::function<void(std::size_t shape, std::span<const Vec3> displacement)>;

/// Gives `take` each shape of the sculpted head once, in no order. Right shapes are the mirror images of left
/// ones, and all but tongueOut are tuned (kinematics_tuner). Lips and the mouth's lining are never pressed
/// into the teeth when a shape that leaves the jaw is full on. One shape is at work at a time: all of them at
/// once would be 25 MB of pages to ask the system for.
void sculpt_shapes(const Sculpt& whole, const TakeShape& take);

/// Adds to a left shape or one of the midline smooth fields about the sites, so that the skin there turns and
/// stretches as real skin does (docs/method/builtin_face.md). `whole` has to outlive it.
using TuneShape = std::function<void(std::size_t shape, std::vector<Vec3>& displacement)>;
[[nodiscard]] TuneShape kinematics_tuner(const Sculpt& whole);

}  // namespace mien::builtin_face
