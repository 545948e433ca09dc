#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command_line.h"
#include "mien/core/error.h"
#include "mien/mocap/marker_cleaning.h"
#include "mien/mocap/marker_retarget.h"
#include "mien/mocap/marker_track.h"

namespace mien::app {

/// How a recording of markers becomes a motion: the options that `mien import` has for it.
struct MarkerImport {
  std::string face = "builtin";
  std::string set;                   ///< A marker set's file; empty: rigs/markers.toml.
  std::vector<std::string> renamed;  ///< "THEIRS=OURS".
  std::vector<std::string> head;     ///< Their markers on a body that is fixed to the head.
  std::vector<double> neutral_s;     ///< Begin and end; or none.
  bool still_head = false;

  void add_to(Command command);
};

/// What came of it.
struct ImportedMarkers {
  builtin_face::MarkerSet set;
  std::vector<std::string> missing;  ///< Of the set.
  std::size_t unlabelled = 0;
  mocap::CleaningReport cleaning;
  mocap::Retargeted retargeted;
};

/// Matches, cleans and retargets a recording. Errors: bad_usage (options), those of the steps.
[[nodiscard]] Result<ImportedMarkers> import_markers(const mocap::MarkerTrack& track,
                                                     const MarkerImport& options);

/// What was found and done, for people and for machines.
[[nodiscard]] std::string markers_text(const ImportedMarkers& imported);
[[nodiscard]] nlohmann::json markers_json(const ImportedMarkers& imported);

}  // namespace mien::app
