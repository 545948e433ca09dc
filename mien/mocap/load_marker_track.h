#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/mocap/marker_track.h"

namespace mien::mocap {

/// Whether a file is a marker recording in a format of load_marker_track(), by its first bytes; false if
/// unreadable.
[[nodiscard]] bool is_marker_recording(const std::filesystem::path& path);

/// Loads a marker recording, of a format detected by its content: Mien's CSV, Motive's CSV, TRC, C3D. Named
/// after the file. `warnings`, if given, receives recoverable faults. Errors: not_found, io, out_of_range
/// (over 1 GiB), unsupported (none of these formats), and the parsers'.
[[nodiscard]] Result<MarkerTrack> load_marker_track(const std::filesystem::path& path,
                                                    std::vector<std::string>* warnings = nullptr);

/// Writes a recording in the format of the file's ending, .trc or .csv. Errors: bad_usage (another ending),
/// write_file()'s.
[[nodiscard]] Result<void> write_marker_track(const std::filesystem::path& path, const MarkerTrack& track);

}  // namespace mien::mocap
