#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "mien/builtin_face/markers.h"
#include "mien/core/error.h"
#include "mien/mocap/marker_swaps.h"
#include "mien/mocap/marker_track.h"
#include "mien/mocap/outliers.h"

namespace mien::mocap {

/// How a recording of markers is cleaned.
struct CleaningSettings {
  /// When the performer's face was neutral, seconds from the recording's start: what stands then where is
  /// taken for where the face model has it at neutral, so that faces of other sizes and forms drive it.
  /// Without it markers are taken to sit on the performer where they sit on the model, which is so of a
  /// recording that was made from it.
  std::optional<std::pair<double, double>> neutral_s;
  /// Standard deviations beyond which a marker is not believed, 1 or more; raising keeps rarer expressions,
  /// and more mistakes.
  double outlier_sigmas = kOutlierSigmas;
  bool remove_head = true;  ///< False: the recording is in frame H already.
};

/// What was found and done; a sample is one marker in one frame.
struct CleaningReport {
  std::size_t frames = 0;
  std::size_t without_head =
      0;  ///< Frames in which the head's place could not be told: all of their markers lost.
  std::size_t samples = 0;     ///< Frames times markers.
  std::size_t lost = 0;        ///< Samples that the recording lacks.
  std::size_t swaps = 0;       ///< Stretches in which two markers had each other's names, ...
  std::size_t mended = 0;      ///< ... their samples that were given back, ...
  std::size_t not_mended = 0;  ///< ... and those where it could not be told: lost.
  std::size_t strays = 0;      ///< Stretches in which a marker was found elsewhere, ...
  std::size_t strayed = 0;     ///< ... and their samples: lost.
  std::size_t outliers = 0;    ///< Samples beyond outlier_sigmas: lost.
  double scale = 1;            ///< The model's size by the performer's; 1 without a neutral.
};

/// A recording ready to be learnt from or to drive a face.
struct CleanMarkers {
  MarkerTrack track;  ///< The set's markers, frame H of the model; lost where not believed.
  /// Head pose in the cameras' frame, p_camera = pose * p_head; none in frames without a head.
  std::vector<std::optional<Eigen::Isometry3d>> head;
  std::vector<MarkerSwap> swaps;
  std::vector<MarkerStray> strays;
  CleaningReport report;
};

/// Takes the head's rigid motion out, by the markers of a body on the head where there are any, else by the
/// reference_markers() of the face; gives swapped markers their names back; loses strays and outliers; and
/// brings all into the model's frame H. What is done to a frame depends on the whole recording. Errors:
/// bad_usage (settings; no frame in the neutral's time), not_found (no frame whose head can be told, too few
/// markers in the neutral's time to tell a pose). Cost: about a second for half an hour at 100 Hz.
[[nodiscard]] Result<CleanMarkers> clean_markers(const MatchedTrack& matched,
                                                 const builtin_face::PlacedMarkers& placed,
                                                 const CleaningSettings& settings = {});

}  // namespace mien::mocap
