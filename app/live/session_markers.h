#pragma once

#include <filesystem>

#include "app/marker_import.h"
#include "mien/core/error.h"
#include "mien/face/motion.h"
#include "mien/take/take.h"

namespace mien::app {

/// The truth of a recorded session, from the markers that a motion capture server sent into it.
struct SessionMarkers {
  ImportedMarkers imported;
  DeviceTime begin;  ///< Of the motion's first frame, on the take's time line (the reference sensor's).
  std::size_t unnamed = 0;  ///< Frames of markers that nobody named: left out.
};

/// Decodes the markers in a take's log and brings their times onto the take's line: the server's clock and
/// the reference sensor's are each fitted to the host's (sensor::ClockModel), as the session does with its
/// sensors'. What the network delays markers more than sensors at its fastest stays in, about a millisecond
/// on a wired network. Errors: the take's, not_found (no markers in it, none with names), import_markers()'s.
[[nodiscard]] Result<SessionMarkers> session_markers(const take::Take& take, const MarkerImport& options);

/// Writes a copy of the take with that truth at its ticks, in place of any truth it has. Errors: the take's
/// and the writer's.
[[nodiscard]] Result<void> write_with_truth(const take::Take& take, const face::Motion& motion,
                                            DeviceTime begin, const std::string& face,
                                            const std::filesystem::path& path, bool replace);

}  // namespace mien::app
