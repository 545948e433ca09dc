#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "lab/trackers/tracker_curves.h"
#include "mien/face/profile.h"

namespace mien::lab {

/// So many periods without a row are a gap, as if the face had been lost: a single frame that was dropped is
/// not (docs/reference/tracker_curves.md, "Gaps").
inline constexpr double kGapPeriods = 3;

/// A tracker's curves at any time: between rows by the monotone cubic, never across a gap.
class TimeLine {
 public:
  /// Copies what it needs.
  explicit TimeLine(const TrackerCurves& curves);

  /// What the tracker tells at that time; none in a gap. Half a period before a run's first row and after its
  /// last that row still counts, so that gaps are as long as the rows that are missing.
  [[nodiscard]] std::optional<face::BlendshapeWeights> at(double time_s) const;
  /// What an avatar shows at that time: in a gap the last row before it, before all rows the neutral face.
  [[nodiscard]] face::BlendshapeWeights held_at(double time_s) const;

 private:
  double reach_s_ = 0;  // Half a period.
  // Of the rows with a face: which run each belongs to, that is, has no gap before it.
  std::vector<double> time_s_;
  std::vector<face::BlendshapeWeights> value_;
  std::vector<face::BlendshapeWeights> slope_;  // A second.
  std::vector<std::size_t> run_;
};

}  // namespace mien::lab
