#pragma once

#include "lab/trackers/trackers_report.h"
#include "mien/core/error.h"
#include "mien/face/face.h"

namespace mien::lab {

/// A row's worst moment, seen from the front: the truth and what each tracker showed, a third of a second
/// before, then, and after; where a tracker saw no face a pale cell. On `face`, whoever performed. Without a
/// strip where the row has no moment. Errors: those of moments_strip().
[[nodiscard]] Result<TrackerPicture> tracker_picture(const face::Face& face, const TrackersRow& row);

}  // namespace mien::lab
