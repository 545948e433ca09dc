#pragma once

#include <vector>

#include "mien/core/random.h"
#include "mien/core/rotation.h"
#include "mien/render/infrared_scene.h"

// Things before the face, as meshes: what hides a mouth, and the frames of spectacles.
namespace mien::virt {

/// A mesh with its places, metres. Both sides are seen.
struct Obstacle {
  render::InfraredThing thing;
  std::vector<Vec3f> vertices_m;
};

/// A tube along a path; `closed` joins its ends. At least two places; radius above 0.
void add_tube(Obstacle& mesh, const std::vector<Vec3f>& path_m, float radius_m, bool closed);

/// A hand with four fingers side by side: the palm's middle at 0, fingers up +Y, its inner side towards -Z.
[[nodiscard]] Obstacle make_hand(Random& random);
/// A cup or glass, its rim's nearest place to the mouth at 0, open upwards, the face towards -Z.
[[nodiscard]] Obstacle make_cup(Random& random);
/// A mask of cloth about nose and mouth: 0 is between nose and lips, the face towards -Z.
[[nodiscard]] Obstacle make_mask(Random& random);
/// The frame of spectacles: 0 is the bridge, the face towards -Z; `eye_x_m` is how far each eye is from it.
[[nodiscard]] Obstacle make_spectacles(float eye_x_m, Random& random);

}  // namespace mien::virt
