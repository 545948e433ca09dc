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

/// Settings of clean_markers(). Method: docs/method/markers.md.
struct CleaningSettings {
  /// Interval in which the performer's face was neutral, s from the recording's start: markers there
  /// correspond to the model's at neutral, so that faces of other size and form can drive it. None: markers
  /// are taken to sit on the performer as on the model (recordings made from it).
  std::optional<std::pair<double, double>> neutral_s;
  /// Outlier threshold, standard deviations of each coordinate over the recording, >= 1 (Asano et al. 2017).
  /// Raising: keeps rarer expressions, and more errors. Lowering: removes more of both.
  double outlier_sigmas = kOutlierSigmas;
  bool remove_head = true;  ///< False: the recording is already in frame H.
};

/// Counts of a cleaning; a sample is one marker in one frame.
struct CleaningReport {
  std::size_t frames = 0;
  std::size_t without_head = 0;  ///< Frames without a head pose: all of their markers are lost.
  std::size_t samples = 0;       ///< Frames times markers.
  std::size_t lost = 0;          ///< Samples that the recording lacks.
  std::size_t swaps = 0;         ///< Stretches with two marker labels swapped, ...
  std::size_t mended = 0;        ///< ... their samples corrected, ...
  std::size_t not_mended = 0;    ///< ... and those that were ambiguous: lost.
  std::size_t strays = 0;        ///< Stretches with a marker displaced by a jump, ...
  std::size_t strayed = 0;       ///< ... and their samples: lost.
  std::size_t outliers = 0;      ///< Samples beyond outlier_sigmas: lost.
  double scale = 1;              ///< Model's size / performer's size; 1 without a neutral.
};

/// A cleaned recording, for training or for driving a face.
struct CleanMarkers {
  MarkerTrack track;  ///< The set's markers, frame H of the model; lost where rejected.
  /// Head pose in the cameras' frame, p_camera = pose * p_head; none in frames without one.
  std::vector<std::optional<Eigen::Isometry3d>> head;
  std::vector<MarkerSwap> swaps;
  std::vector<MarkerStray> strays;
  CleaningReport report;
};

/// Removes the head's rigid motion, by the markers of a body on the head, else by the face's
/// reference_markers(); corrects swapped labels; removes stray markers and outliers; transforms all into the
/// model's frame H. Not causal: each frame depends on the whole recording. Errors: bad_usage (settings; no
/// frame in the neutral interval), not_found (no frame with a head pose, too few markers in the neutral
/// interval for a pose). Cost: about a second for half an hour at 100 Hz.
[[nodiscard]] Result<CleanMarkers> clean_markers(const MatchedTrack& matched,
                                                 const builtin_face::PlacedMarkers& placed,
                                                 const CleaningSettings& settings = {});

}  // namespace mien::mocap
