#pragma once

#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/mocap/marker_table.h"
#include "mien/mocap/marker_track.h"

namespace mien::mocap {

/// Whether a text is a TRC file: it begins "PathFileType".
[[nodiscard]] bool is_trc(std::string_view text);

/// The text format of Motion Analysis and OpenSim: tabs between cells; a line that begins "PathFileType";
/// names of properties (DataRate, NumMarkers, Units, ...) and a line of their values; "Frame#", "Time" and
/// the markers' names, each above three columns; X1, Y1, Z1, X2, ...; an empty line or none; frames. A marker
/// is lost where its cells are empty or "nan", and at 0, 0, 0, which some programs write. Times are the Time
/// column's; declared rates and frame counts are ignored. Errors: malformed (a line missing, more or fewer
/// names than NumMarkers), unsupported (a unit), and those of read_marker_rows.
[[nodiscard]] Result<MarkerRecording> parse_trc(std::string_view text, const std::string& name);
/// In millimetres; lost markers are empty cells. The rate is that of the median step.
[[nodiscard]] std::string format_trc(const MarkerTrack& track);

}  // namespace mien::mocap
