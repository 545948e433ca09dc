#include "mien/mocap/marker_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <set>
#include <utility>

#include "mien/core/excerpt.h"

namespace mien::mocap {
namespace {

std::string_view trim(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

bool is_nothing(std::string_view cell) {
  return cell.empty() || lower(cell) == "nan";
}

std::string_view unquoted(std::string_view cell) {
  cell = trim(cell);
  if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"')
    cell = trim(cell.substr(1, cell.size() - 2));
  return cell;
}

/// One marker's position in a row; kLostMarker where there is none.
Result<Vec3f> position_in(const std::vector<std::string_view>& cells, const MarkerTable& table,
                          const MarkerTable::Column& column, const std::string& where) {
  const auto cell = [&](std::size_t i) { return i < cells.size() ? cells[i] : std::string_view(); };
  const auto empty = std::ranges::count_if(column.cell, [&](std::size_t i) { return is_nothing(cell(i)); });
  if (empty == 3) return kLostMarker;
  const std::string place = fmt::format("{}, marker {}", where, excerpt(column.name));
  if (empty > 0) return fail(ErrorCode::malformed, "half a position", place);
  Vec3 position;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    MIEN_TRY_ASSIGN(position[axis], number_in(cell(column.cell[static_cast<std::size_t>(axis)]), place));
  }
  if (table.zero_is_lost && position.isZero(0)) return kLostMarker;
  position *= table.metres;
  if (!(position.cwiseAbs().maxCoeff() <= kMaxTrackPositionM))
    return fail(ErrorCode::out_of_range, fmt::format("farther than {} m from the origin", kMaxTrackPositionM),
                place, "see whether the file names the right unit");
  return Vec3f(position.cast<float>());
}

}  // namespace

std::string_view next_line(std::string_view& text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  const auto end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::vector<std::string_view> cells_of(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  std::size_t begin = 0;
  bool quoted = false;
  for (std::size_t i = 0; i <= line.size(); ++i) {
    if (i < line.size() && line[i] == '"') quoted = !quoted;
    if (i < line.size() && (quoted || line[i] != separator)) continue;
    cells.push_back(unquoted(line.substr(begin, i - begin)));
    begin = i + 1;
  }
  return cells;
}

Result<double> number_in(std::string_view cell, const std::string& where) {
  if (cell.starts_with('+')) cell.remove_prefix(1);
  double value = 0;
  const auto [end, code] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (cell.empty() || end != cell.data() + cell.size() || code == std::errc::invalid_argument)
    return fail(ErrorCode::malformed, fmt::format("'{}' is no number", excerpt(cell)), where);
  if (code != std::errc() || !std::isfinite(value))
    return fail(ErrorCode::out_of_range, fmt::format("'{}' is out of range", excerpt(cell)), where);
  return value;
}

Result<double> unit_m(std::string_view name, const std::string& where) {
  constexpr std::pair<std::string_view, double> kUnits[] = {
      {"mm", 1e-3}, {"millimeters", 1e-3}, {"millimetres", 1e-3},
      {"cm", 1e-2}, {"centimeters", 1e-2}, {"centimetres", 1e-2},
      {"m", 1},     {"meters", 1},         {"metres", 1}};
  const std::string wanted = lower(name);
  for (const auto& [unit, metres] : kUnits)
    if (wanted == unit) return metres;
  return fail(ErrorCode::unsupported, fmt::format("lengths in '{}'", excerpt(name)), where,
              "export in mm, cm or m");
}

Result<void> check_markers(const std::vector<std::string>& markers, const std::string& where) {
  if (markers.empty()) return fail(ErrorCode::malformed, "there is no marker", where);
  if (markers.size() > kMaxTrackMarkers)
    return fail(ErrorCode::out_of_range, fmt::format("more than {} markers", kMaxTrackMarkers), where);
  std::set<std::string_view> names;
  for (const std::string& name : markers) {
    if (name.empty()) return fail(ErrorCode::malformed, "a marker without a name", where);
    if (std::ranges::any_of(name,
                            [](unsigned char c) { return c < 0x20 || c == 0x7F || c == ',' || c == '"'; }))
      return fail(ErrorCode::malformed, "a marker's name with a comma, a quote or what is no letter in it",
                  where);
    if (!names.insert(name).second)
      return fail(ErrorCode::malformed, fmt::format("two markers are called '{}'", excerpt(name)), where);
  }
  return {};
}

Result<MarkerRecording> read_marker_rows(std::string_view rows, std::size_t first_line,
                                         const MarkerTable& table, const std::string& name) {
  MarkerRecording recording;
  MarkerTrack& track = recording.track;
  for (const MarkerTable::Column& column : table.columns) track.markers.push_back(column.name);
  MIEN_TRY(check_markers(track.markers, name));
  std::vector<Vec3f> row;
  for (std::size_t number = first_line; !rows.empty(); ++number) {
    const bool ends = rows.find('\n') != std::string_view::npos;
    std::vector<std::string_view> cells = cells_of(next_line(rows), table.separator);
    while (!cells.empty() && cells.back().empty()) cells.pop_back();
    if (cells.empty()) continue;
    const std::string where = fmt::format("{}, line {}", name, number);
    const auto read = [&]() -> Result<double> {
      row.clear();
      if (cells.size() > table.cells)
        return fail(ErrorCode::malformed, fmt::format("{} cells, not {}", cells.size(), table.cells), where);
      if (cells.size() <= table.time_cell) return fail(ErrorCode::malformed, "a row without a time", where);
      MIEN_TRY_ASSIGN(const double time_s, number_in(cells[table.time_cell], where));
      if (std::abs(time_s) > kMaxTrackTimeS)
        return fail(ErrorCode::out_of_range, "no time of a recording", where);
      if (!track.time_s.empty() && time_s <= track.time_s.back())
        return fail(ErrorCode::malformed, "the time does not rise", where);
      for (const MarkerTable::Column& column : table.columns) {
        MIEN_TRY_ASSIGN(row.emplace_back(), position_in(cells, table, column, where));
      }
      return time_s;
    };
    auto time_s = read();
    if (!time_s && !ends) {
      recording.warnings.push_back(fmt::format("the last row, line {}, is cut short and left out", number));
      break;
    }
    if (!time_s) return std::unexpected(std::move(time_s).error());
    track.time_s.push_back(*time_s);
    track.position_m.insert(track.position_m.end(), row.begin(), row.end());
  }
  if (track.time_s.empty()) return fail(ErrorCode::truncated, "there is no frame in it", name);
  return recording;
}

}  // namespace mien::mocap
