#pragma once

#include <vector>

#include "mien/builtin_face/markers.h"
#include "mien/core/error.h"
#include "mien/face/motion.h"
#include "mien/face/weight_solver.h"
#include "mien/mocap/marker_cleaning.h"

namespace mien::mocap {

/// A face's motion that brings its own markers to where a recording's are.
struct Retargeted {
  face::Motion
      motion;  ///< A frame for each of the recording's; without a face where too few markers were seen.
  double residual_mm = 0;              ///< Mean distance of the face's markers from the recording's.
  std::vector<double> residual_of_mm;  ///< Of each marker; 0 where it was never seen.
  std::size_t without_face = 0;        ///< Frames.
};

/// Weights of a face from markers (face::WeightSolver), frame by frame in order. A frame in which fewer than
/// half of the markers are seen that the recording has at all has no face. The head's turn and place are told
/// against the first frame that has them, in whose axes +Y is up: cameras' axes are anybody's. Errors:
/// mismatch (another number of markers), the solver's.
[[nodiscard]] Result<Retargeted> retarget_markers(const CleanMarkers& clean,
                                                  const builtin_face::PlacedMarkers& placed,
                                                  const face::WeightSolverSettings& settings = {});

/// A motion as markers on a face's skin, frame H: what export writes and retarget_markers() takes back.
/// Frames without a face have all markers lost.
[[nodiscard]] MarkerTrack markers_of_motion(const face::Motion& motion,
                                            const builtin_face::PlacedMarkers& placed,
                                            const builtin_face::MarkerSet& set);

}  // namespace mien::mocap
