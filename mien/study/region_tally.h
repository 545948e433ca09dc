#pragma once

#include <array>

#include "mien/face/output_frame.h"
#include "mien/study/reliability.h"

namespace mien::study {

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

}  // namespace mien::study
