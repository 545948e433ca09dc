#include "mien/mocap/trc.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <vector>

#include "mien/core/excerpt.h"
#include "mien/core/median.h"

namespace mien::mocap {
namespace {

constexpr std::string_view kBegins = "PathFileType";

/// 1 / the median step; 0 where there is none.
double rate_hz(const MarkerTrack& track) {
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < track.frames(); ++i) steps_s.push_back(track.time_s[i] - track.time_s[i - 1]);
  return steps_s.empty() ? 0 : 1 / upper_median(std::move(steps_s));
}

}  // namespace

bool is_trc(std::string_view text) {
  return next_line(text).starts_with(kBegins);
}

Result<MarkerRecording> parse_trc(std::string_view text, const std::string& name) {
  if (!next_line(text).starts_with(kBegins))
    return fail(ErrorCode::malformed, "it does not begin with 'PathFileType'", name);
  const std::vector<std::string_view> facts = cells_of(next_line(text), '\t');
  const std::vector<std::string_view> values = cells_of(next_line(text), '\t');
  const auto value = [&](std::string_view fact) -> Result<std::string_view> {
    for (std::size_t i = 0; i < std::min(facts.size(), values.size()); ++i)
      if (facts[i] == fact && !values[i].empty()) return values[i];
    return fail(ErrorCode::malformed, fmt::format("'{}' is not said", fact), name + ", lines 2 and 3",
                "cells of a TRC stand between tabs");
  };
  MIEN_TRY_ASSIGN(const std::string_view units, value("Units"));
  MIEN_TRY_ASSIGN(const std::string_view marker_count, value("NumMarkers"));
  MIEN_TRY_ASSIGN(const double promised, number_in(marker_count, name + ", line 3"));

  MarkerTable table;
  table.separator = '\t';
  table.time_cell = 1;
  table.zero_is_lost = true;
  MIEN_TRY_ASSIGN(table.metres, unit_m(units, name + ", line 3"));
  const std::vector<std::string_view> names = cells_of(next_line(text), '\t');
  if (names.size() < 2 || names[0] != "Frame#" || names[1] != "Time")
    return fail(ErrorCode::malformed, "no 'Frame#' and 'Time' above the columns", name + ", line 4");
  for (std::size_t c = 2; c < names.size(); ++c) {
    if (names[c].empty()) continue;
    const std::size_t first = 2 + 3 * table.columns.size();
    if (c != first)
      return fail(ErrorCode::malformed,
                  fmt::format("marker '{}' does not stand above three columns", excerpt(names[c])),
                  name + ", line 4");
    table.columns.push_back({.name = std::string(names[c]), .cell = {first, first + 1, first + 2}});
  }
  if (promised != static_cast<double>(table.columns.size()))
    return fail(ErrorCode::malformed,
                fmt::format("{} markers are named, and NumMarkers is {}", table.columns.size(), promised),
                name);
  table.cells = 2 + 3 * table.columns.size();
  const std::vector<std::string_view> axes = cells_of(next_line(text), '\t');
  if (axes.size() < 3 || !axes[2].starts_with('X'))
    return fail(ErrorCode::malformed, "no X1, Y1, Z1 below the names", name + ", line 5");
  return read_marker_rows(text, 6, table, name);
}

std::string format_trc(const MarkerTrack& track) {
  std::string out;
  auto end = std::back_inserter(out);
  const double rate = rate_hz(track);
  out += "PathFileType\t4\t(X/Y/Z)\tmarkers.trc\n";
  out +=
      "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n";
  fmt::format_to(end, "{0:.2f}\t{0:.2f}\t{1}\t{2}\tmm\t{0:.2f}\t1\t{1}\n", rate, track.frames(),
                 track.count());
  out += "Frame#\tTime";
  for (const std::string& marker : track.markers) fmt::format_to(end, "\t{}\t\t", marker);
  out += "\n\t";
  for (std::size_t m = 1; m <= track.count(); ++m) fmt::format_to(end, "\tX{0}\tY{0}\tZ{0}", m);
  out += "\n\n";
  for (std::size_t i = 0; i < track.frames(); ++i) {
    fmt::format_to(end, "{}\t{:.6f}", i + 1, track.time_s[i]);
    for (const Vec3f& position_m : track.frame(i)) {
      const Vec3 mm = 1e3 * position_m.cast<double>();
      if (is_seen(position_m))
        fmt::format_to(end, "\t{:.3f}\t{:.3f}\t{:.3f}", mm.x(), mm.y(), mm.z());
      else
        out += "\t\t\t";
    }
    out += '\n';
  }
  return out;
}

}  // namespace mien::mocap
