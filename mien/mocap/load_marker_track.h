#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/mocap/marker_track.h"

namespace mien::mocap {

/// Whether a file is a recording of markers in one of the formats of load_marker_track(), by its first bytes.
/// False where it cannot be read.
[[nodiscard]] bool is_marker_recording(const std::filesystem::path& path);

/// The markers in a recording, told apart by its content: our CSV, Motive's CSV, TRC, C3D. Named after the
/// file. `warnings`, where given, tells what was survived. Errors: not_found, io, out_of_range (over 1 GiB),
/// unsupported (none of these formats), and the parsers'.
[[nodiscard]] Result<MarkerTrack> load_marker_track(const std::filesystem::path& path,
                                                    std::vector<std::string>* warnings = nullptr);

/// Writes a recording in the format of the file's ending, .trc or .csv. Errors: bad_usage (another ending),
/// write_file()'s.
[[nodiscard]] Result<void> write_marker_track(const std::filesystem::path& path, const MarkerTrack& track);

}  // namespace mien::mocap
