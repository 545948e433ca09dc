#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "mien/core/error.h"
#include "mien/mocap/marker_table.h"

namespace mien::mocap {

/// Whether the bytes begin like a C3D file: key 0x50 in the second byte, behind the block number of the
/// parameters.
[[nodiscard]] bool is_c3d(std::span<const std::byte> bytes);

/// The 3-D points of a C3D file (c3d.org): Intel byte order, points as scaled integers or floats, metres out.
/// Names, rate, unit and count from the POINT group; analogue channels are ignored. A point is lost where its
/// residual is below 0. Points without a label are named "*1", "*2", ... by index. The first frame is at 0 s.
/// Errors: malformed, truncated (fewer frames than declared), unsupported (another processor's byte order, a
/// unit), out_of_range (no rate, a position beyond kMaxTrackPositionM, too many points). Declared sizes are
/// bounded by the bytes present.
[[nodiscard]] Result<MarkerRecording> parse_c3d(std::span<const std::byte> bytes, const std::string& name);

}  // namespace mien::mocap
