#pragma once

#include <optional>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/face/face.h"
#include "mien/face/motion.h"
#include "mien/performer/style.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/imu/device_faults.h"
#include "mien/virtual/imu/skin_site.h"
#include "mien/virtual/session.h"

namespace mien::virt {

/// A face, and who moves it.
struct VirtualPerson {
  face::Face face;
  performer::Style style;
};

/// A person of the built-in family, from the streams "identity" and "style".
[[nodiscard]] VirtualPerson draw_person(const Random& root);

/// `seconds` of a random script, from the streams "script" and "motion".
[[nodiscard]] face::Motion draw_motion(double seconds, const performer::Style& style, const Random& root);

/// A recorded performance, and the face that it is played on.
struct GivenMotion {
  face::Motion motion;
  std::size_t face = 0;  ///< In the request's faces.
};

/// How the sensors are worn, and what is wrong with them.
struct Wearing {
  /// Of the profile *device*. `mount_position_mm` is the placement's error.
  DeviceFaults faults;
  bool lab = false;     ///< The profile *lab* instead: no faults, and the sensors are where they belong.
  double turn_rad = 0;  ///< Standard deviation by which the skin under each sensor lies another way.
  /// How each shape's effect on each site differs from the mesh's own; none: not at all.
  std::optional<KinematicsSpread> kinematics;
};

/// What somebody did, on what skin, and what the devices sent.
struct Performance {
  std::vector<SkinSite> sites;  ///< Of the rig's sensors, in its order.
  VirtualSession session;
  double begin_s = 0;  ///< Of the motion in the session, after the prologue.
  double end_s = 0;
};

/// Lets a face perform a motion after a brief prologue; a motion without a head gets the default one, but in
/// *lab*. Streams: "placement", "turns", "kinematics", "head", "prologue", "devices": who wears the same
/// sensors another way keeps all else. Errors: bad_usage (a motion without frames); those of the sites and
/// the devices.
[[nodiscard]] Result<Performance> perform_with(const Wearing& wearing, const face::Face& face,
                                               face::Motion motion, const sensor::Rig& rig,
                                               const Random& random);

}  // namespace mien::virt
