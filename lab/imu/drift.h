#pragma once

#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/imu/drift_filter.h"
#include "mien/sensor/rig.h"

namespace mien::lab {

/// Who performs for the study: virtual performers on the built-in family of faces, with the rig's own faults,
/// after a brief prologue; face and head both move.
struct DriftRequest {
  int performers = 12;   ///< 1 or more.
  double seconds = 120;  ///< Of each performance after the prologue, above 0.
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
};

/// How far a setting's skin rotations lie from the truth, as angles in the head frame, over the face sensors
/// and the evaluated frames in which the pipeline gave one.
struct Drift {
  imu::DriftSettings settings;
  double rms_deg = 0;
  double vertical_rms_deg = 0;            ///< The part about the head's vertical, where headings err.
  std::vector<double> performer_rms_deg;  ///< Of each performer, ascending.
  double missing = 0;                     ///< Share of rotations that the pipeline did not give.
};

/// Every setting on the same sessions. Errors: those of the faults and the simulator; cancelled.
[[nodiscard]] Result<std::vector<Drift>> study_drift(const DriftRequest& request, const sensor::Rig& rig,
                                                     std::span<const imu::DriftSettings> settings,
                                                     const Progress& progress);

}  // namespace mien::lab
