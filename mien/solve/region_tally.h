#pragma once

#include <array>
#include <optional>
#include <vector>

#include "mien/face/output_frame.h"
#include "mien/measure/evaluation.h"
#include "mien/solve/reliability.h"

namespace mien::solve {

/// Whether the mean absolute error of each region's shapes is at most model::kConfidenceTolerance.
[[nodiscard]] std::array<bool, face::kShapeRegionCount> regions_within(
    const face::BlendshapeWeights& estimate, const face::BlendshapeWeights& truth);

/// How true the regions' confidence of many frames is.
struct RegionTally {
  Reliability all;  ///< All regions alike.
  RocArea roc;
  std::array<Reliability, face::kShapeRegionCount> each;
  std::array<RocArea, face::kShapeRegionCount> roc_each;

  void add(const face::OutputFrame& frame, const face::BlendshapeWeights& truth);
  void add(const RegionTally& other);
};

/// Expected calibration error of the regions' confidence over the evaluated frames of all takes, all regions
/// alike; of a region whose confidence is unknown in a frame, that frame says nothing. Absent where it is
/// known of none.
[[nodiscard]] std::optional<double> expected_region_error(const std::vector<measure::TakeEstimates>& takes);

}  // namespace mien::solve
