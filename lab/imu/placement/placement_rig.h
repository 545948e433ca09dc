#pragma once

#include <string>
#include <vector>

#include "lab/imu/placement/sensor_candidates.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/imu/skin_motion.h"

namespace mien::lab {

/// A rig of these candidates and of the head sensor of `base`, which is its reference, with the faults of
/// `base`. Devices are the virtual nodes of `mien perform --to`, from 0 on; places are rounded to a tenth of
/// a millimetre. No [skin]. Errors: not_found (`base` has no head sensor), bad_usage (no candidate).
[[nodiscard]] Result<sensor::Rig> rig_of(const std::vector<SensorCandidate>& candidates,
                                         const sensor::Rig& base, const std::string& name);

/// The same with its [skin], which keeps headings from drifting. Errors: and those of study_skin_motion().
[[nodiscard]] Result<sensor::Rig> worn_rig_of(const std::vector<SensorCandidate>& candidates,
                                              const sensor::Rig& base, const std::string& name,
                                              const virt::SkinMotionRequest& skin, const Progress& progress);

/// The recipe of a live model for a rig that none was trained for: as models/recipes/live.toml, with fewer
/// people and a quarter of an hour.
[[nodiscard]] std::string placement_recipe();

}  // namespace mien::lab
