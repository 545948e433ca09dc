#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/imu/drift_filter.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"
#include "mien/tracker/jitter_filter.h"

namespace mien::lab {

/// On whom settings are chosen: virtual people of the built-in family with streams of their own, each of whom
/// performs the mixed script on the same face in the profiles *device* and *lab*.
struct JitterRequest {
  int performers = 24;  ///< 1 or more.
  double seconds = 24;  ///< Of each performance after the prologue, above 0.
  std::uint64_t seed = 301;
  unsigned threads = 0;  ///< 0: one a core.
};

/// What a jitter filter leaves in one profile: means over the people (docs/reference/metrics.md).
struct FilteredFigures {
  double mse = 0;
  double pve_mm = 0;
  double jitter_ratio = 0;
  double blink_f1 = 0;  ///< Of who blinks; 0 where nobody does.
};

/// A filter, or none, and what it leaves.
struct JitterTrial {
  std::optional<tracker::JitterSettings> settings;  ///< None: the network's answers as they are.
  FilteredFigures device, lab;
};

/// Every filter on the same answers of the causal model. The same request gives the same figures on any
/// number of threads. Errors: bad_usage (nobody performs), mismatch (a model that is not causal), those of
/// the faults and the simulator; cancelled. Cost: two seconds of a core a filter and person.
[[nodiscard]] Result<std::vector<JitterTrial>> study_jitter(
    const JitterRequest& request, const sensor::Rig& rig, const model::ModelFile& model,
    std::span<const std::optional<tracker::JitterSettings>> filters, const Progress& progress);

/// Index of the filter with the least vertex error, both profiles together, of those that leave at most
/// `limit` times the truth's jitter in each; nothing where none does.
[[nodiscard]] std::optional<std::size_t> best_filter(std::span<const JitterTrial> trials, double limit);

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
  double vertical_rms_deg = 0;  ///< The part about the head's vertical, where headings err.
};

/// Every setting on the same sessions. Errors: those of the faults and the simulator; cancelled.
[[nodiscard]] Result<std::vector<Drift>> study_drift(const DriftRequest& request, const sensor::Rig& rig,
                                                     std::span<const imu::DriftSettings> settings,
                                                     const Progress& progress);

}  // namespace mien::lab
