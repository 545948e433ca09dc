#include "mien/mocap/marker_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <vector>

#include "mien/core/excerpt.h"

namespace mien::mocap {
namespace {

constexpr std::string_view kTimeCell = "time_s";
constexpr std::string_view kMotiveCell = "Format Version";
/// Most rows of Motive's header.
constexpr std::size_t kMaxMotiveRows = 32;

std::string_view first_cell(std::string_view text, char separator) {
  const auto cells = cells_of(next_line(text), separator);
  return cells.empty() ? std::string_view() : cells.front();
}

/// "brow_inner_R_x_mm" split into its parts.
struct ColumnName {
  std::string_view marker;
  char axis = 'x';
  std::string_view unit;
};

std::optional<ColumnName> parse_column(std::string_view cell) {
  ColumnName column;
  const auto unit = cell.rfind('_');
  if (unit == std::string_view::npos || unit < 3 || cell[unit - 2] != '_') return std::nullopt;
  column.unit = cell.substr(unit + 1);
  column.axis = cell[unit - 1];
  column.marker = cell.substr(0, unit - 2);
  return column;
}

}  // namespace

bool is_marker_csv(std::string_view text) {
  while (text.starts_with('#') || text.starts_with("\xEF\xBB\xBF#")) (void)next_line(text);
  return first_cell(text, ',') == kTimeCell;
}

bool is_motive_csv(std::string_view text) {
  return first_cell(text, ',') == kMotiveCell;
}

Result<MarkerRecording> parse_marker_csv(std::string_view text, const std::string& name) {
  std::size_t line = 1;
  for (; text.starts_with('#') || text.starts_with("\xEF\xBB\xBF#"); ++line) (void)next_line(text);
  std::vector<std::string_view> header = cells_of(next_line(text), ',');
  const std::string where = fmt::format("{}, line {}", name, line);
  while (!header.empty() && header.back().empty()) header.pop_back();
  if (header.empty() || header.front() != kTimeCell)
    return fail(ErrorCode::malformed, "the first column is not 'time_s'", where);
  MarkerTable table;
  table.cells = header.size();
  std::string_view unit;
  for (std::size_t c = 1; c < header.size(); ++c) {
    const auto column = parse_column(header[c]);
    const std::size_t axis = (c - 1) % 3;
    if (!column || column->axis != "xyz"[axis] || (axis > 0 && column->marker != table.columns.back().name))
      return fail(ErrorCode::malformed,
                  fmt::format("column '{}' is not the {} of a marker", excerpt(header[c]), "xyz"[axis]),
                  where,
                  "columns are NAME_x_mm, NAME_y_mm, NAME_z_mm of one marker after the other, or ..._m");
    if (column->unit != "mm" && column->unit != "m")
      return fail(ErrorCode::malformed, fmt::format("column '{}' has no unit", excerpt(header[c])), where,
                  "end all of them in _mm, or all in _m");
    if (!unit.empty() && column->unit != unit)
      return fail(ErrorCode::malformed, "columns of different units", where);
    unit = column->unit;
    if (axis == 0) table.columns.push_back({.name = std::string(column->marker)});
    table.columns.back().cell[axis] = c;
  }
  if (header.size() % 3 != 1)
    return fail(ErrorCode::malformed, "the last marker has not three columns", where);
  table.metres = unit == "mm" ? 1e-3 : 1;
  return read_marker_rows(text, line + 1, table, name);
}

std::string format_marker_csv(const MarkerTrack& track) {
  std::string out(kTimeCell);
  auto end = std::back_inserter(out);
  for (const std::string& marker : track.markers) fmt::format_to(end, ",{0}_x_mm,{0}_y_mm,{0}_z_mm", marker);
  out += '\n';
  for (std::size_t i = 0; i < track.frames(); ++i) {
    fmt::format_to(end, "{:.6f}", track.time_s[i]);
    for (const Vec3f& position_m : track.frame(i)) {
      const Vec3 mm = 1e3 * position_m.cast<double>();
      if (is_seen(position_m))
        fmt::format_to(end, ",{:.3f},{:.3f},{:.3f}", mm.x(), mm.y(), mm.z());
      else
        out += ",,,";
    }
    out += '\n';
  }
  return out;
}

Result<MarkerRecording> parse_motive_csv(std::string_view text, const std::string& name) {
  const std::vector<std::string_view> facts = cells_of(next_line(text), ',');
  if (facts.front() != kMotiveCell) return fail(ErrorCode::malformed, "not an export of Motive", name);
  std::optional<double> metres;
  for (std::size_t i = 0; i + 1 < facts.size(); i += 2) {
    if (facts[i] != "Length Units") continue;
    MIEN_TRY_ASSIGN(metres, unit_m(facts[i + 1], name));
  }
  if (!metres) return fail(ErrorCode::malformed, "it does not say its 'Length Units'", name);

  std::vector<std::string_view> types, names, meanings, axes;
  std::size_t line = 2;
  for (; line < 2 + kMaxMotiveRows && axes.empty() && !text.empty(); ++line) {
    const std::vector<std::string_view> cells = cells_of(next_line(text), ',');
    const std::string_view second = cells.size() > 1 ? cells[1] : std::string_view();
    if (cells.front() == "Frame" && second.starts_with("Time"))
      axes = cells;
    else if (second == "Type")
      types = cells;
    else if (second == "Name")
      names = cells;
    else if (second.empty() && std::ranges::find(cells, "Position") != cells.end())
      meanings = cells;
  }
  if (types.empty() || names.empty() || meanings.empty() || axes.empty())
    return fail(ErrorCode::malformed, "its header lacks a row: Type, Name, Position, or Frame and Time", name,
                "export with the header on");
  MarkerTable table;
  table.time_cell = 1;
  table.cells = axes.size();
  table.metres = *metres;
  const auto is_position = [&](std::size_t c) {
    return c < types.size() && c < names.size() && c < meanings.size() && types[c] == "Marker" &&
           meanings[c] == "Position";
  };
  for (std::size_t c = 2; c + 2 < axes.size(); ++c) {
    if (!is_position(c) || axes[c] != "X") continue;
    if (axes[c + 1] != "Y" || axes[c + 2] != "Z" || !is_position(c + 1) || !is_position(c + 2) ||
        names[c + 1] != names[c] || names[c + 2] != names[c])
      return fail(ErrorCode::malformed, fmt::format("marker '{}' has not three axes", excerpt(names[c])),
                  name);
    table.columns.push_back({.name = std::string(names[c]), .cell = {c, c + 1, c + 2}});
  }
  if (table.columns.empty())
    return fail(ErrorCode::malformed, "no column is the position of a marker", name,
                "export with Markers on");
  return read_marker_rows(text, line, table, name);
}

}  // namespace mien::mocap
