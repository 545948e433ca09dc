#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/core/progress.h"
#include "mien/face/output_frame.h"
#include "mien/measure/interval.h"
#include "mien/measure/metrics.h"
#include "mien/measure/pieces.h"
#include "mien/take/take.h"

namespace mien::measure {

inline constexpr std::size_t kProvenanceCount = static_cast<std::size_t>(face::Provenance::neutral) + 1;

/// "measured", "predicted", ...
[[nodiscard]] std::string_view provenance_name(face::Provenance provenance);

/// Of each shape, the share of the frames in which the answer came about in each way; its sum is 1.
using ProvenanceShares = std::array<std::array<double, kProvenanceCount>, face::kShapeCount>;

/// An estimate of the whole of one take, beside its truth; both at the take's ticks.
struct TakeEstimates {
  std::string take;                            ///< The file's name.
  std::vector<take::TruthFrame> truth;         ///< One a tick.
  std::vector<face::BlendshapeWeights> model;  ///< One a tick.
  std::vector<face::BlendshapeWeights> ridge;  ///< One a tick; empty when the model file has none.
  /// How the model's weights came about, one a tick; empty where that is not known.
  std::vector<std::array<face::Provenance, face::kShapeCount>> provenance = {};
  /// Where the model's eyes look, one a tick; empty: as its weights say.
  std::vector<EyeDirections> gaze_rad = {};
  /// The model's confidence of the regions, one a tick; empty where it has none.
  std::vector<std::array<float, face::kShapeRegionCount>> region_confidence = {};
};

/// The estimate with one step of shaping left out.
struct Ablation {
  std::string without;   ///< The step's name.
  bool changed = false;  ///< Whether that changed any bit of the weights.
  Metrics metrics;
};

/// One take, piece by piece.
struct TakePieces {
  std::string take;  ///< The file's name.
  std::vector<Piece> pieces;
};

/// Errors of the model over several wears of the sensors: the mean over the wears, of all takes as one, and
/// where it lies with 95 % confidence (mean_interval of one seed).
struct Wears {
  std::size_t count = 0;
  Interval pve_mm, mse, pve_about_rest_mm, mse_about_rest;
};

/// The model beside its baselines on the same frames.
struct Evaluation {
  std::size_t frames = 0;
  std::size_t takes = 0;
  Metrics model;
  Metrics mean_pose;
  Metrics hold_last;
  std::optional<Metrics> ridge;
  /// What the answer itself said of its shapes: measured is what the model's table calls so for the sensors
  /// that sent. Absent where an estimate does not say.
  std::optional<ProvenanceShares> provenance;
  /// Expected calibration error of the regions' confidence; absent where it is known of none.
  std::optional<double> ece;
  std::optional<Metrics>
      blinking;  ///< The model with made blinks (shaping::Blinks). Absent unless asked for.
  std::vector<Ablation> ablations;  ///< Empty unless they were asked for.
  std::vector<TakePieces> pieces;   ///< Of each take; empty unless they were asked for.
  std::optional<Wears> wears;       ///< Absent unless they were asked for.
};

/// The frames that count, those evaluated and with a face, as stretches without a gap: [begin, end).
[[nodiscard]] std::vector<std::pair<std::size_t, std::size_t>> evaluated_runs(
    std::span<const take::TruthFrame> truth);

/// The baseline hold_last: the truth one second ago; where the face was lost then, the last one seen before.
/// One a tick.
[[nodiscard]] std::vector<face::BlendshapeWeights> hold_last(std::span<const take::TruthFrame> truth);

/// One estimate of one take over its evaluated frames with a face. Shape: both one a tick.
[[nodiscard]] Metrics measure_track(const Meter& meter, std::span<const take::TruthFrame> truth,
                                    std::span<const face::BlendshapeWeights> estimate);

/// One sentence for each baseline that is closer to the truth than the model in any error, which names the
/// errors with both values; empty where the model is ahead of all. Errors: PVE, landmarks, MSE, MSE of 42.
[[nodiscard]] std::vector<std::string> baselines_ahead(const Evaluation& evaluation);

/// The same takes shaped otherwise, measured as evaluate() measures the model but for eyes and rests.
/// `weights`: of each take, one a tick.
[[nodiscard]] Metrics measure_shaped(const Meter& meter, const std::vector<TakeEstimates>& takes,
                                     std::span<const std::vector<face::BlendshapeWeights>> weights);

/// The same with one step of shaping left out.
[[nodiscard]] Ablation measure_ablation(const Meter& meter, const std::vector<TakeEstimates>& takes,
                                        std::string without,
                                        std::span<const std::vector<face::BlendshapeWeights>> weights);

/// Sums up what evaluate() measured of the same takes, one evaluation a wear of the sensors. At least two.
[[nodiscard]] Wears over_wears(std::span<const Evaluation> evaluations);

/// Measures over the evaluated frames with a face, of all takes as one. `mean_pose` is the training set's.
/// Errors: not_found when no frame is left to measure.
[[nodiscard]] Result<Evaluation> evaluate(const Meter& meter, const std::vector<TakeEstimates>& takes,
                                          const face::BlendshapeWeights& mean_pose);

}  // namespace mien::measure
