#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "mien/face/face.h"
#include "mien/face/profile.h"
#include "mien/measure/eyes_and_lips.h"
#include "mien/measure/stretch.h"

namespace mien::measure {

/// Mean and standard deviation over frames.
struct MeanStd {
  double mean = 0;
  double std = 0;
};

struct ShapeScore {
  double mae = 0;
  std::optional<double> pearson;  ///< Absent where the truth or the estimate does not move.
};

/// Errors of the motion alone, since a receiver's avatar has a neutral of its own: each shape of the estimate
/// is shifted so that it rests where the truth does. A shape's rest is its 10th percentile over the measured
/// frames of a take.
struct MotionErrors {
  double mse = 0;
  double pve_mm = 0;
};

/// What `mien evaluate` prints for one estimate (docs/reference/metrics.md has every definition).
struct Metrics {
  std::size_t frames = 0;
  double mse = 0;                      ///< All 53 shapes, both sides clipped to [0, 1].
  double mse_observed = 0;             ///< A fixed 42 of them: without gaze, eyeWide and mouthShrugUpper.
  MeanStd pve_mm;                      ///< All vertices but hair and clothes.
  std::optional<MeanStd> pve_face_mm;  ///< Vertices of the region "skin".
  std::optional<MeanStd> lmk_mm;       ///< The 68 landmarks.
  std::optional<double> jitter_ratio;  ///< Third difference of the landmarks over the truth's own.
  std::optional<double> blink_f1;      ///< Absent when neither truth nor estimate has a blink.
  /// Shares of the frames with the eyes shut: the mean of both eyeBlink weights is 0.5 or more.
  double shut = 0, truth_shut = 0;
  std::array<ShapeScore, face::kShapeCount> per_shape{};
  /// Absent where they were not asked for: evaluate() does.
  std::optional<MotionErrors> about_rest;
  std::optional<EyesAndLips> eyes_and_lips;

  std::vector<float> mse_curve;     ///< One a frame.
  std::vector<float> pve_mm_curve;  ///< One a frame.
  std::vector<float> lmk_mm_curve;  ///< One a frame; empty without landmarks.
};

/// Whether `mse_observed` counts a shape: a fixed list, whatever the sensors. Which shapes sensors *measure*
/// is what an answer's provenance says.
[[nodiscard]] bool counts_in_mse_observed(std::size_t shape);

/// Measures vertex errors on one face; prepared once, used for many estimates. Thread-safe after
/// construction.
class Meter {
 public:
  explicit Meter(const face::Face& face);

  /// All stretches as one. Errors in millimetres on M(w) with both sides clipped to [0, 1].
  [[nodiscard]] Metrics measure(std::span<const Stretch> stretches) const;
  /// Of the same face.
  [[nodiscard]] const EyesAndLipsMeter& eyes_and_lips() const { return eyes_and_lips_; }

 private:
  struct VertexShapes {  // Which shapes move a vertex, and how: CSR over all vertices.
    std::vector<std::uint32_t> first;
    std::vector<std::uint16_t> shape;
    std::vector<Vec3f> delta_mm;
  };
  struct Sums;
  struct Batch;
  /// Errors of up to so many frames from `first` on.
  [[nodiscard]] static Batch add_weights(const Stretch& stretch, std::size_t first, Sums& sums, Metrics& out);
  void add_vertices(const Batch& batch, Sums& sums, Metrics& out) const;
  void add_landmarks(const Stretch& stretch, Sums& sums, Metrics& out) const;

  VertexShapes shapes_;
  std::vector<std::uint8_t> in_pve_;  // Vertices that pve_mm averages over.
  std::size_t in_pve_count_ = 0;
  std::vector<std::uint8_t> in_skin_;
  std::size_t skin_count_ = 0;
  std::vector<std::uint32_t> landmarks_;
  std::vector<Vec3f> landmark_neutral_mm_;
  EyesAndLipsMeter eyes_and_lips_;
};

/// F1 of blinks: a blink is a weight crossing 0.5 upwards, matched one to one within `tolerance` frames; both
/// eyes of all stretches pooled. Absent when neither side has one.
[[nodiscard]] std::optional<double> blink_f1(std::span<const Stretch> stretches, int tolerance = 2);

/// The same of winks: blinks of one eye during which, and `tolerance` frames around, the other one's weight
/// stays below 0.5.
[[nodiscard]] std::optional<double> wink_f1(std::span<const Stretch> stretches, int tolerance = 2);

}  // namespace mien::measure
