#include "lab/trackers/tracker_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <span>
#include <utility>

#include "lab/trackers/mediapipe_scores.h"
#include "lab/trackers/openseeface_log.h"
#include "mien/core/ascii.h"
#include "mien/core/excerpt.h"
#include "mien/core/files.h"
#include "mien/core/median.h"
#include "mien/core/monotone_cubic.h"
#include "mien/core/nearest_word.h"
#include "mien/face/livelink_csv.h"
#include "mien/face/profile_names.h"
#include "mien/face/target_names.h"

namespace mien::lab {
namespace {

constexpr std::size_t kMaxTrackerFileBytes = std::size_t{1} << 30U;
/// Bytes of a file by which its format is told: enough for a header of a thousand names.
constexpr std::size_t kTellingBytes = std::size_t{1} << 16U;
/// No camera is quicker, and slopes between rows stay finite.
constexpr double kLeastTrackerStep_s = 1e-6;

/// Every name that is known, as it is usually spelt: for "did you mean".
const std::vector<std::string>& curve_name_list() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out = face::mediapipe52().shapes;
    out.emplace_back("tongueOut");
    for (const std::string_view own : face::kShapeNames)
      if (std::ranges::find(out, own) == out.end()) out.emplace_back(own);
    return out;
  }();
  return names;
}

std::string_view first_line_of(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return text.substr(0, text.find('\n'));
}

/// Takes the next cell from a header's line, without the blanks around it; none at its end.
std::optional<std::string_view> next_header_cell(std::optional<std::string_view>& line) {
  if (!line) return std::nullopt;
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t comma = line->find(',');
  const std::string_view cell = line->substr(0, comma);
  line = comma == std::string_view::npos ? std::nullopt : std::optional(line->substr(comma + 1));
  const std::size_t first = cell.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return std::string_view();
  return cell.substr(first, cell.find_last_not_of(kBlank) - first + 1);
}

bool names_column(std::string_view header, std::string_view column) {
  std::optional<std::string_view> rest = header;
  while (const auto cell = next_header_cell(rest))
    if (equal_ignoring_case(*cell, column)) return true;
  return false;
}

}  // namespace

std::string_view trimmed_cell(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\"";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::string_view cut_line(std::string_view& text) {
  const std::size_t at = text.find('\n');
  const std::string_view line = text.substr(0, at);
  text = at == std::string_view::npos ? std::string_view() : text.substr(at + 1);
  return line;
}

std::optional<double> number_in(std::string_view cell) {
  double value = 0;
  const auto [end, code] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (code != std::errc{} || end != cell.data() + cell.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::vector<std::string_view> table_cells(std::string_view line) {
  std::vector<std::string_view> cells;
  while (cells.size() <= kMaxTableColumns) {
    const std::size_t comma = line.find(',');
    cells.push_back(trimmed_cell(line.substr(0, comma)));
    if (comma == std::string_view::npos) break;
    line = line.substr(comma + 1);
  }
  return cells;
}

double TrackerCurves::period_s() const {
  if (rows.size() < 2) return 0;
  std::vector<double> steps;
  steps.reserve(rows.size() - 1);
  for (std::size_t i = 1; i < rows.size(); ++i) steps.push_back(rows[i].time_s - rows[i - 1].time_s);
  return upper_median(std::move(steps));
}

Result<std::span<const std::size_t>> CurveNames::shapes(std::string_view name, const std::string& where) {
  auto found = known_.find(name);
  if (found == known_.end()) {
    std::vector<std::size_t> shapes;
    if (!equal_ignoring_case(name, "_neutral")) {
      shapes = face::shapes_of_name(name);
      if (shapes.empty())
        return fail(ErrorCode::malformed, fmt::format("no shape is called '{}'", excerpt(name)), where,
                    "it takes the names of ARKit, MediaPipe and Mien" +
                        did_you_mean(name.substr(0, kExcerptLetters), curve_name_list()));
      std::erase(shapes, face::kShapeCount);  // tongueOut.
    }
    found = known_.emplace(std::string(name), std::move(shapes)).first;
  }
  return std::span<const std::size_t>(found->second);
}

Result<void> add_row(TrackerCurves& curves, TrackerRow row, const std::string& where) {
  if (!std::isfinite(row.time_s) || std::abs(row.time_s) > kMostTrackerTime_s)
    return fail(ErrorCode::out_of_range, "the time is no number of seconds", where);
  if (curves.rows.size() == kMaxTrackerRows)
    return fail(ErrorCode::out_of_range, fmt::format("there are more than {} rows", kMaxTrackerRows), where,
                "cut the recording into parts");
  if (!curves.rows.empty() && !(row.time_s - curves.rows.back().time_s >= kLeastTrackerStep_s))
    return fail(
        ErrorCode::malformed,
        fmt::format("the time {:.6f} s does not rise after {:.6f} s", row.time_s, curves.rows.back().time_s),
        where, "remove the rows of one of the two recordings, or sort them by time");
  curves.rows.push_back(row);
  return {};
}

Result<TrackerCurves> parse_livelink_curves(std::string_view text, const std::string& name) {
  MIEN_TRY_ASSIGN(const face::LiveLinkCsv csv, face::parse_livelink_csv(text, name));
  if (csv.rows.size() > kMaxTrackerRows)
    return fail(ErrorCode::out_of_range, fmt::format("there are more than {} rows", kMaxTrackerRows), name,
                "cut the recording into parts");
  const face::LiveLinkMotion loaded = face::motion_from_livelink(csv, name);
  TrackerCurves out{.name = name, .rows = {}, .told = {}, .warnings = loaded.warnings};
  for (const face::MotionFrame& frame : loaded.motion.frames) {
    TrackerRow& row =
        out.rows.emplace_back(TrackerRow{.time_s = frame.time_s + loaded.start_s, .weights = {}});
    if (frame.has_face) row.weights = frame.weights;
  }
  // A shape without a column reads as 0 there: it was not told.
  std::optional<std::string_view> rest = first_line_of(text);
  while (const auto cell = next_header_cell(rest)) {
    if (face::arkit_index(*cell) >= face::kArkitCount) continue;
    for (const std::size_t k : face::shapes_of_name(*cell))
      if (k < face::kShapeCount) out.told.set(k);
  }
  return out;
}

TrackerCurves counted_from_start(TrackerCurves curves) {
  const double first_s = curves.first_s();
  for (TrackerRow& row : curves.rows) row.time_s -= first_s;
  return curves;
}

std::optional<CurvesFormat> curves_format(std::span<const std::byte> bytes) {
  const auto front = bytes.first(std::min(bytes.size(), kTellingBytes));
  const std::string_view text(reinterpret_cast<const char*>(front.data()), front.size());
  const std::string_view line = first_line_of(text);
  // A block's numbers have zeros in them everywhere; text has none.
  const bool binary =
      std::ranges::find(front.first(std::min(front.size(), kOpenSeeFaceBlockBytes)), std::byte{0}) !=
      front.first(std::min(front.size(), kOpenSeeFaceBlockBytes)).end();
  if (binary) return CurvesFormat::openseeface_blocks;
  if (line.starts_with('{')) return CurvesFormat::mediapipe_lines;
  if (names_column(line, "RightOpen") && names_column(line, "LeftOpen")) return CurvesFormat::openseeface_csv;
  if (names_column(line, "Timecode")) return CurvesFormat::livelink_csv;
  for (const std::string_view time : kScoreTimeColumns)
    if (names_column(line, time)) return CurvesFormat::scores_csv;
  return std::nullopt;
}

Result<TrackerCurves> parse_tracker_curves(std::span<const std::byte> bytes, const std::string& name) {
  if (bytes.empty()) return fail(ErrorCode::truncated, "there is nothing in it", name);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::optional<CurvesFormat> format = curves_format(bytes);
  if (!format)
    return fail(
        ErrorCode::unsupported,
        fmt::format("this is no recording of a tracker that is known; it begins with '{}'",
                    excerpt(text.substr(0, text.find('\n')))),
        name,
        "give a Live Link Face CSV, MediaPipe's results as one JSON object a line, a CSV with a column "
        "time_s or timestamp_ms, or a recording of OpenSeeFace");
  switch (*format) {
    case CurvesFormat::livelink_csv:
      return parse_livelink_curves(text, name);
    case CurvesFormat::mediapipe_lines:
      return parse_mediapipe_lines(text, name);
    case CurvesFormat::scores_csv:
      return parse_scores_csv(text, name);
    case CurvesFormat::openseeface_blocks:
      return parse_openseeface_blocks(bytes, name);
    case CurvesFormat::openseeface_csv:
      return parse_openseeface_csv(text, name);
  }
  return fail(ErrorCode::internal, "a format without a reader", name);
}

Result<TrackerCurves> read_tracker_curves(const std::filesystem::path& path) {
  if (path.extension() == ".mien")
    return fail(ErrorCode::bad_usage, "this is a take, not a tracker's curves", path.string(),
                "solve it first: mien solve TAKE --out FILE.csv");
  MIEN_TRY_ASSIGN(const std::vector<std::byte> bytes, read_file(path, kMaxTrackerFileBytes));
  MIEN_TRY_ASSIGN(TrackerCurves curves, parse_tracker_curves(bytes, path.string()));
  curves.name = path.stem().string();
  const bool seen =
      std::ranges::any_of(curves.rows, [](const TrackerRow& row) { return row.weights.has_value(); });
  if (!seen)
    return fail(ErrorCode::not_found, "the face is lost in every row", path.string(),
                "record with the face before the camera");
  constexpr double kSlowest_s = 1;  // Between rows of what is a tracker at all.
  if (curves.period_s() > kSlowest_s)
    return fail(ErrorCode::out_of_range, fmt::format("its rows are {:.3g} s apart", curves.period_s()),
                path.string(), "give seconds in a column time_s, or milliseconds in one called timestamp_ms");
  return curves;
}

TimeLine::TimeLine(const TrackerCurves& curves) {
  const double period_s = curves.period_s();
  reach_s_ = 0.5 * period_s;
  const double longest_s = kGapPeriods * period_s;
  std::size_t run = 0;
  bool lost = false;
  double last_s = curves.first_s();
  for (const TrackerRow& row : curves.rows) {
    // A little more than three periods is three: times are rounded to milliseconds.
    if (row.time_s - last_s > longest_s + 0.1 * period_s) lost = true;
    last_s = row.time_s;
    if (!row.weights) {
      lost = true;
      continue;
    }
    if (lost && !time_s_.empty()) ++run;
    lost = false;
    time_s_.push_back(row.time_s);
    value_.push_back(*row.weights);
    run_.push_back(run);
  }
  slope_.resize(value_.size());
  std::vector<float> value, slope;
  for (std::size_t begin = 0, end = 0; begin < run_.size(); begin = end) {
    while (end < run_.size() && run_[end] == run_[begin]) ++end;
    const std::size_t count = end - begin;
    value.resize(count);
    slope.resize(count);
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      if (!curves.told[k]) continue;
      for (std::size_t i = 0; i < count; ++i) value[i] = value_[begin + i][k];
      monotone_slopes(std::span(time_s_).subspan(begin, count), value, slope);
      for (std::size_t i = 0; i < count; ++i) slope_[begin + i][k] = slope[i];
    }
  }
}

std::optional<face::BlendshapeWeights> TimeLine::at(double time_s) const {
  const auto above = static_cast<std::size_t>(std::ranges::upper_bound(time_s_, time_s) - time_s_.begin());
  const bool has_below = above > 0, has_above = above < time_s_.size();
  if (has_below && has_above && run_[above - 1] == run_[above]) {
    const std::size_t below = above - 1;
    face::BlendshapeWeights out;
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      out[k] = hermite(time_s_[below], value_[below][k], slope_[below][k], time_s_[above], value_[above][k],
                       slope_[above][k], time_s);
    return out;
  }
  if (has_below && time_s - time_s_[above - 1] <= reach_s_) return value_[above - 1];
  if (has_above && time_s_[above] - time_s <= reach_s_) return value_[above];
  return std::nullopt;
}

face::BlendshapeWeights TimeLine::held_at(double time_s) const {
  if (const auto seen = at(time_s)) return *seen;
  const auto above = static_cast<std::size_t>(std::ranges::upper_bound(time_s_, time_s) - time_s_.begin());
  return above > 0 ? value_[above - 1] : face::BlendshapeWeights{};
}

}  // namespace mien::lab
