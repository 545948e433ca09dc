#pragma once

#include <array>
#include <optional>
#include <span>

#include "mien/face/face.h"
#include "mien/measure/stretch.h"

namespace mien::measure {

/// Where eyes look, how far lids and lips are apart (docs/reference/metrics.md has every definition). Absent
/// where the truth lacks it, or nothing moves.
struct EyesAndLips {
  struct Angle {
    double median = 0;
    double p90 = 0;
  };
  std::optional<Angle> gaze_deg;  ///< Between solved and true direction of each eye that is open in truth.
  std::optional<double> openness_pearson;  ///< Of the gaps of the lids.
  std::optional<double> lip_gap_f1;        ///< Frames whose lips are less than kClosedLips_mm apart.
};

/// Measures them on one face, which needs landmarks: all is absent of one without. Prepared once. Thread-safe
/// after construction.
class EyesAndLipsMeter {
 public:
  static constexpr float kClosedLips_mm = 1;
  /// An eye whose lids are open less than this, as a share of the gap in the neutral, may look anywhere.
  static constexpr float kOpenEye = 0.4F;

  explicit EyesAndLipsMeter(const face::Face& face);

  /// All stretches as one.
  [[nodiscard]] EyesAndLips measure(std::span<const Stretch> stretches) const;

  /// Gap between the lids, left and right: 0 closed, 1 as in the neutral. Of a face with landmarks.
  [[nodiscard]] std::array<float, 2> openness(const face::BlendshapeWeights& weights) const;
  /// From the middle of the upper lip's inner edge down to that of the lower one, mm; below 0 where they have
  /// gone through each other. Of a face with landmarks.
  [[nodiscard]] float lip_gap_mm(const face::BlendshapeWeights& weights) const;

 private:
  /// A height above another, mm: linear in the weights.
  struct Gap {
    float neutral = 0;
    std::array<float, face::kShapeCount> per_weight{};
    [[nodiscard]] float at(const face::BlendshapeWeights& weights) const;
  };
  bool has_landmarks_ = false;
  std::array<Gap, 2> lids_;
  Gap lips_;
};

}  // namespace mien::measure
