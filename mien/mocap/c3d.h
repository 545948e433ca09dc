#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "mien/core/error.h"
#include "mien/mocap/marker_table.h"

namespace mien::mocap {

/// Whether bytes begin as a C3D file does: the key 50 (hex) is its second byte, behind the place of its
/// parameters.
[[nodiscard]] bool is_c3d(std::span<const std::byte> bytes);

/// The 3-D points of a C3D file (the binary format of biomechanics): Intel's byte order, points as scaled
/// integers or as floats. Their names, rate, unit and number are the POINT group's; analogue channels are
/// passed over. A point is lost where its residual is below 0. Points without a label of their own are called
/// "*1", "*2", ... by their place. The first frame is at 0 s. Errors: malformed, truncated (fewer frames than
/// it says), unsupported (another processor's byte order, a unit), out_of_range (no rate, a position beyond
/// kMaxTrackPositionM, too many points). No size that the file states is believed beyond the bytes that are
/// there.
[[nodiscard]] Result<MarkerRecording> parse_c3d(std::span<const std::byte> bytes, const std::string& name);

}  // namespace mien::mocap
