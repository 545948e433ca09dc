#pragma once

#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/core/rotation.h"
#include "mien/face/face.h"
#include "mien/render/infrared_scene.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/headset/headset_faults.h"

namespace mien::virt {

/// A camera as this headset has it, glued a little off; frame H of the wearer's head, before it is seated.
struct FittedCamera {
  std::string name;
  bool of_mouth = false;
  sensor::CameraMount mount;  ///< look_at_m, up and lamps are those of the built-in head: use what follows.
  Vec3f position_m = Vec3f::Zero(), look_at_m = Vec3f::Zero(), up = Vec3f::UnitY();
  float field_of_view_rad = 1, radial_k1 = 0;
  Eigen::Vector2f centre = Eigen::Vector2f::Constant(0.5F);  ///< Of the axis, shares of the picture.
};

/// How a headset has moved against where it was fitted: turned about the cameras' middle, then shifted.
/// Frame H.
struct HeadsetSeat {
  Vec3 shift_m = Vec3::Zero();
  Vec3 tilt_rad = Vec3::Zero();  ///< Rotation vector.
};

/// A person who wears a headset: face, looks, and the headset as it was made.
struct HeadsetWearer {
  face::Face face;  ///< Coloured as at 850 nm, where it has colours.
  render::InfraredWearer looks;
  std::vector<FittedCamera> cameras;  ///< Of the rig's, in its order.
  std::vector<render::InfraredLamp> lamps;
  Vec3f middle_m = Vec3f::Zero();  ///< Of the cameras: what tilts turn about.
  std::vector<Vec3f> things_m;     ///< Places of looks.things.
  double pupil_mm = 4;             ///< Mean diameter.
};

/// Puts the rig's headset onto a face: it keeps its shape, and is laid on by the middle of the eyes, farther
/// forward where a camera or lamp would stand too close to the neutral skin. Looks and parts are drawn.
/// Errors: not_found (no cameras; a face without eyeballs and without landmarks), out_of_range (a camera
/// inside the head, by its name).
[[nodiscard]] Result<HeadsetWearer> seat_headset(face::Face face, const sensor::Rig& rig,
                                                 const HeadsetFaults& faults, const Random& random);

/// The same on a random identity of the built-in face.
[[nodiscard]] Result<HeadsetWearer> draw_headset_wearer(const sensor::Rig& rig, const HeadsetFaults& faults,
                                                        const Random& random);

}  // namespace mien::virt
