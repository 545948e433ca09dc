#pragma once

#include <cstdint>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/sensor/rig.h"

namespace mien::virt {

/// Whose skin: virtual performers of the built-in family, an even share of KinematicsSpread and of 3 mm
/// of placement off the standard skin, in performances of every kind.
struct SkinMotionRequest {
  int performers = 1500;  ///< 1 or more.
  double seconds = 45;    ///< Of each performance, above 0.
  std::uint64_t seed = 91;
  unsigned threads = 0;  ///< 0: one a core.
};

/// How the skin under a rig's face sensors turns, for its `[skin]` table: true rotations, twice a second,
/// rounded to hundredths of a degree. The same for any number of threads. Errors: those of the sites (a
/// sensor without one); bad_usage (no sensor is on the skin); cancelled. Cost: 15 ms of one core a performer
/// of 45 s.
[[nodiscard]] Result<sensor::SkinMotion> study_skin_motion(const SkinMotionRequest& request,
                                                           const sensor::Rig& rig, const Progress& progress);

}  // namespace mien::virt
