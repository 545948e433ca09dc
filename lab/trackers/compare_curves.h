#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lab/trackers/tracker_curves.h"
#include "mien/core/error.h"
#include "mien/measure/metrics.h"

namespace mien::lab {

/// By how much a tracker's curves come later than the truth.
struct TrackerLag {
  double lag_s = 0;      ///< Positive: late.
  double sigma_s = 0;    ///< Standard error, by leaving out a sixth of the time in turn (jackknife).
  double agreement = 0;  ///< Correlation at that shift over all told shapes, each about its own mean.
};

/// How far from the truth, over some frames. Weights of both sides are held to 0 to 1.
struct CurveErrors {
  double pve_mm = 0;                  ///< All vertices; shapes that are not told are taken from the truth.
  std::optional<double> pve_face_mm;  ///< The same of the skin of the face.
  std::optional<double> landmarks_mm;
  double mse_told = 0;  ///< Over the shapes that the tracker tells.
  /// Over the shapes that every tracker beside it tells too; absent where there is none.
  std::optional<double> mse_common;
};

/// One tracker beside the truth.
struct CurveScore {
  std::string name;
  ToldShapes told_shapes;                  ///< That the truth has too.
  std::size_t seen = 0;                    ///< Frames of the comparison in which it saw the face.
  double gap_share = 0;                    ///< Of the frames, those in which it did not; moved as `held` is.
  std::optional<TrackerLag> lag;           ///< Absent where the face hardly moves, or nothing agrees.
  std::optional<CurveErrors> as_told;      ///< Over the frames it saw, its lag in it; absent: it saw none.
  std::optional<CurveErrors> without_lag;  ///< The same moved by its lag; absent without one.
  /// Without a shared clock, none was found: what follows has an offset in it that nobody knows.
  bool offset_unknown = false;
  /// Over all frames: an avatar holds the last face in a gap. Without a shared clock moved by the lag.
  CurveErrors held;
  /// As `held`, with 0 for the shapes that are not told: what an avatar shows that has nothing else.
  double pve_whole_mm = 0;
  double mse_whole = 0;  ///< Likewise over all 53.

  // One a frame of the comparison, moved as `held` is.
  std::vector<face::BlendshapeWeights> shown;  ///< Held where it saw nothing.
  std::vector<bool> saw;
  std::vector<float> pve_mm;  ///< Of `shown`.
};

/// Trackers beside the truth, on the truth's own frames: those that lie in the time of all recordings, and in
/// which the truth has a face.
struct CurveComparison {
  bool shared_clock = true;
  std::vector<double> time_s;
  std::vector<face::BlendshapeWeights> truth;
  ToldShapes common;  ///< What all trackers and the truth tell.
  std::vector<CurveScore> scores;
};

struct CompareSettings {
  /// Lags are sought within plus and minus this, s. Raising finds later trackers, and may take one nod for
  /// the next.
  double search_s = 0.5;
  /// All times are of one clock, so that a tracker's lag is its own and stands in its errors. Else it has in
  /// it when somebody began to record: the lag that is found of each is taken out of all that is over all
  /// frames.
  bool shared_clock = true;
};

/// What does a lag need: so much time seen together, s, shapes that move by so much (root mean square about
/// their means, all told shapes as one), and so much agreement.
inline constexpr double kLagLeast_s = 2, kLagLeastMotion = 0.01, kLagLeastAgreement = 0.3;

/// Holds each tracker to the truth on one time line. The shift between them is told from the error: each is
/// measured as it is, and again moved by the lag that was found. Without a shared clock the time in common is
/// that of the moved curves. Shapes that the truth itself does not tell are left out everywhere. Method:
/// docs/reference/tracker_curves.md. Cost: some seconds a minute and tracker.
///
/// Errors: bad_usage (no tracker, two of one name, a search beyond 5 s), not_found (no truth, none with a
/// face), mismatch (a recording that has less than a second in common with the truth, or with the others; it
/// says when both are; or no shape in common with the truth).
[[nodiscard]] Result<CurveComparison> compare_curves(const measure::Meter& meter, const TrackerCurves& truth,
                                                     std::span<const TrackerCurves> trackers,
                                                     const CompareSettings& settings = {});

}  // namespace mien::lab
