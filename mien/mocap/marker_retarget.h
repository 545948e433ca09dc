#pragma once

#include <vector>

#include "mien/builtin_face/markers.h"
#include "mien/core/error.h"
#include "mien/face/motion.h"
#include "mien/face/weight_solver.h"
#include "mien/mocap/marker_cleaning.h"

namespace mien::mocap {

/// Motion of a face whose markers fit a recording's.
struct Retargeted {
  face::Motion motion;                 ///< A frame for each of the recording's; some without a face.
  double residual_mm = 0;              ///< Mean distance of the face's markers from the recording's, mm.
  std::vector<double> residual_of_mm;  ///< Of each marker; 0 where it was never seen.
  std::size_t without_face = 0;        ///< Number of frames without a face.
};

/// Weights of a face from markers (face::WeightSolver), frame by frame in order. A frame with fewer than half
/// of the recording's markers has no face. Head pose: relative to the first frame that has one, in whose axes
/// +Y is up, since the cameras' axes are arbitrary. Errors: mismatch (another number of markers), the
/// solver's.
[[nodiscard]] Result<Retargeted> retarget_markers(const CleanMarkers& clean,
                                                  const builtin_face::PlacedMarkers& placed,
                                                  const face::WeightSolverSettings& settings = {});

/// A motion as markers on a face's skin, frame H, m: the inverse of retarget_markers(), for export. Frames
/// without a face have all markers lost.
[[nodiscard]] MarkerTrack markers_of_motion(const face::Motion& motion,
                                            const builtin_face::PlacedMarkers& placed,
                                            const builtin_face::MarkerSet& set);

}  // namespace mien::mocap
