#pragma once

#include <bitset>
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/profile.h"

// What a face tracker told of a face, whichever it is (docs/reference/tracker_curves.md).
namespace mien::lab {

/// Columns of a tracker's table, at most; no more cells of a line are looked at.
inline constexpr std::size_t kMaxTableColumns = 1024;

/// Without blanks and quotes around it.
[[nodiscard]] std::string_view trimmed_cell(std::string_view text);
/// Cuts the first line from the text; a carriage return at its end stays.
[[nodiscard]] std::string_view cut_line(std::string_view& text);
/// What stands between commas, trimmed: of a line with more than kMaxTableColumns columns one cell more.
[[nodiscard]] std::vector<std::string_view> table_cells(std::string_view line);
/// The whole cell as a number; nothing where it is none, or not finite.
[[nodiscard]] std::optional<double> number_in(std::string_view cell);

/// Which of the 53 shapes a tracker tells at all; the others are never held against it.
using ToldShapes = std::bitset<face::kShapeCount>;

/// One frame of a tracker.
struct TrackerRow {
  double time_s = 0;  ///< On the recording's own clock.
  /// Shapes that are not told are 0. None: the tracker saw no face.
  std::optional<face::BlendshapeWeights> weights;
};

/// One tracker's recording.
struct TrackerCurves {
  std::string name;
  std::vector<TrackerRow> rows;  ///< time_s strictly ascending, finite.
  ToldShapes told;
  std::vector<std::string> warnings;  ///< What was survived.

  [[nodiscard]] double first_s() const { return rows.empty() ? 0 : rows.front().time_s; }
  [[nodiscard]] double last_s() const { return rows.empty() ? 0 : rows.back().time_s; }
  /// Median time between rows, s; 0 with fewer than two.
  [[nodiscard]] double period_s() const;
};

/// Rows of one recording at most: four and a half hours at 60 a second.
inline constexpr std::size_t kMaxTrackerRows = 1'000'000;
/// Longest line of a text format, bytes: MediaPipe's landmarks beside its scores take some 100 KB.
inline constexpr std::size_t kMaxTrackerLine = std::size_t{4} << 20U;
/// Largest weight, each way, that is taken for one: percent, and what is no weight, are refused.
inline constexpr double kMostTrackerWeight = 1.5;
/// Times beyond this, s, are no clock's: the year 2286 in seconds since 1970.
inline constexpr double kMostTrackerTime_s = 1e10;

/// The shapes of the names in one recording: ARKit's, MediaPipe's and ours, in any case; browInnerUp and
/// cheekPuff give both sides, _neutral and tongueOut none. Asks the table once a name.
class CurveNames {
 public:
  /// `shapes` is valid as long as this object. Errors: malformed, with the nearest name.
  [[nodiscard]] Result<std::span<const std::size_t>> shapes(std::string_view name, const std::string& where);

 private:
  std::map<std::string, std::vector<std::size_t>, std::less<>> known_;
};

/// Appends a row. Errors: out_of_range (a time that is not finite or beyond kMostTrackerTime_s, more than
/// kMaxTrackerRows), malformed (a time that does not rise, by a
/// microsecond at least). `where` says which row.
[[nodiscard]] Result<void> add_row(TrackerCurves& curves, TrackerRow row, const std::string& where);

/// A Live Link Face recording; rows without a face are gaps, times are its time code in seconds. Told is what
/// has a column. Errors: those of face::parse_livelink_csv.
[[nodiscard]] Result<TrackerCurves> parse_livelink_curves(std::string_view text, const std::string& name);

/// The same with its first row at 0 s: for recordings whose clocks have nothing to do with each other.
[[nodiscard]] TrackerCurves counted_from_start(TrackerCurves curves);

/// What kind of recording a file is, by how it begins.
enum class CurvesFormat : std::uint8_t {
  livelink_csv,
  mediapipe_lines,
  scores_csv,
  openseeface_blocks,
  openseeface_csv
};
/// None: nothing that is known. Looks at the first bytes alone.
[[nodiscard]] std::optional<CurvesFormat> curves_format(std::span<const std::byte> bytes);

/// Any of these formats. `name` is what errors call it, and the curves' name. Errors: truncated (nothing in
/// it), unsupported (no format that is known), and those of its reader.
[[nodiscard]] Result<TrackerCurves> parse_tracker_curves(std::span<const std::byte> bytes,
                                                         const std::string& name);

/// The same of a file, named after it. Errors: not_found, io, bad_usage (a take, a folder), out_of_range
/// (more than 1 GiB); those of parse_tracker_curves(); not_found where the face is lost in every row.
[[nodiscard]] Result<TrackerCurves> read_tracker_curves(const std::filesystem::path& path);

/// So many periods without a row are a gap, as if the face had been lost: a single frame that was dropped is
/// not (docs/reference/tracker_curves.md, "Gaps").
inline constexpr double kGapPeriods = 3;

/// A tracker's curves at any time: between rows by the monotone cubic, never across a gap.
class TimeLine {
 public:
  /// Copies what it needs.
  explicit TimeLine(const TrackerCurves& curves);

  /// What the tracker tells at that time; none in a gap. Half a period before a run's first row and after its
  /// last that row still counts, so that gaps are as long as the rows that are missing.
  [[nodiscard]] std::optional<face::BlendshapeWeights> at(double time_s) const;
  /// What an avatar shows at that time: in a gap the last row before it, before all rows the neutral face.
  [[nodiscard]] face::BlendshapeWeights held_at(double time_s) const;

 private:
  double reach_s_ = 0;  // Half a period.
  // Of the rows with a face: which run each belongs to, that is, has no gap before it.
  std::vector<double> time_s_;
  std::vector<face::BlendshapeWeights> value_;
  std::vector<face::BlendshapeWeights> slope_;  // A second.
  std::vector<std::size_t> run_;
};

}  // namespace mien::lab
