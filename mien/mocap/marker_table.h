#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/mocap/marker_track.h"

// What the text formats of marker recordings have in common: rows of cells, a time and three numbers a
// marker.
namespace mien::mocap {

/// Result of a recording's parser.
struct MarkerRecording {
  MarkerTrack track;
  std::vector<std::string> warnings;  ///< Recoverable faults: a truncated last row.
};

/// Layout of a table's rows.
struct MarkerTable {
  struct Column {
    std::string name;
    std::array<std::size_t, 3> cell{};  ///< Cell indices of x, y and z.
  };
  char separator = ',';
  std::size_t time_cell = 0;
  std::vector<Column> columns;
  std::size_t cells = 0;  ///< Number of cells of a complete row.
  double metres = 1;      ///< Unit of its positions, m.
  /// Whether 0, 0, 0 means lost, as of programs without empty cells.
  bool zero_is_lost = false;
};

/// Removes the first line from `text` and returns it without line end, carriage return and byte order mark.
[[nodiscard]] std::string_view next_line(std::string_view& text);
/// The cells of a line, without surrounding blanks and double quotes. Separators within quotes do not count.
[[nodiscard]] std::vector<std::string_view> cells_of(std::string_view line, char separator);
/// The number that fills a cell. Errors: malformed, out_of_range (not finite, but "nan" where it may be
/// lost).
[[nodiscard]] Result<double> number_in(std::string_view cell, const std::string& where);
/// Metres of "mm", "cm", "m" and of their English names, in any case. Errors: unsupported.
[[nodiscard]] Result<double> unit_m(std::string_view name, const std::string& where);

/// Checks a recording's markers. Errors: malformed (none, one without a name, two of one name, a comma, quote
/// or control character in a name), out_of_range (more than kMaxTrackMarkers).
[[nodiscard]] Result<void> check_markers(const std::vector<std::string>& markers, const std::string& where);

/// Reads the rows of a table; the first is line `first_line` of the file `name`. A marker is lost where its
/// three cells are empty or "nan"; cells missing at a row's end are empty. Blank lines are ignored. Errors:
/// malformed (more cells than the table has, half a position, a time that does not rise), out_of_range (a
/// number beyond kMaxTrackPositionM or kMaxTrackTimeS), truncated (no row); a malformed last line without a
/// line end is skipped, with a warning.
[[nodiscard]] Result<MarkerRecording> read_marker_rows(std::string_view rows, std::size_t first_line,
                                                       const MarkerTable& table, const std::string& name);

}  // namespace mien::mocap
