#pragma once

#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/mocap/marker_table.h"
#include "mien/mocap/marker_track.h"

namespace mien::mocap {

/// Whether a text is Mien's marker CSV: its first cell is "time_s".
[[nodiscard]] bool is_marker_csv(std::string_view text);
/// Whether it is OptiTrack Motive's CSV export: its first cell is "Format Version".
[[nodiscard]] bool is_motive_csv(std::string_view text);

/// Mien's CSV of markers: one line of names, then a line a frame.
///
///     time_s,brow_inner_R_x_mm,brow_inner_R_y_mm,brow_inner_R_z_mm,brow_inner_L_x_mm,...
///     0,-17.02,58.11,104.93,17.11,...
///
/// The unit is "mm" or "m", the same in all columns. A lost marker has three empty cells. Lines beginning
/// with '#' before the names are comments. Errors: malformed (another first cell, a column that is not the
/// next of x, y, z, mixed units), and those of read_marker_rows. docs/guide/markers.md.
[[nodiscard]] Result<MarkerRecording> parse_marker_csv(std::string_view text, const std::string& name);
/// In millimetres with three decimals, times with six.
[[nodiscard]] std::string format_marker_csv(const MarkerTrack& track);

/// The CSV that OptiTrack's Motive exports (format versions 1.1x to 1.2x): names and values in its first
/// line, then rows "Type", "Name", ..., a row of "Position" and "Rotation", and "Frame,Time...,X,Y,Z,...".
/// Only positions of type "Marker", the measured ones, are read; rigid bodies, bones and their solved markers
/// are not. Errors: malformed (a row or a unit missing, no marker's position), unsupported (a unit), and
/// those of read_marker_rows.
[[nodiscard]] Result<MarkerRecording> parse_motive_csv(std::string_view text, const std::string& name);

}  // namespace mien::mocap
