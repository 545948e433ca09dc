#include "mien/face/livelink_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "mien/core/ascii.h"
#include "mien/core/excerpt.h"
#include "mien/core/files.h"
#include "mien/core/median.h"

namespace mien::face {
namespace {

inline constexpr std::size_t kShapeColumns = 52;
inline constexpr std::array<std::string_view, 9> kAngleNames = {
    "HeadYaw",     "HeadPitch",   "HeadRoll",      "LeftEyeYaw",  "LeftEyePitch",
    "LeftEyeRoll", "RightEyeYaw", "RightEyePitch", "RightEyeRoll"};
/// A weight is about 0 to 1 and an angle a few radians: what is beyond this is neither.
inline constexpr double kMaxValue = 100;
inline constexpr std::size_t kMaxColumns = 1024;
inline constexpr std::size_t kUnknown = kLiveLinkValueCount;

/// What a header's cell stands for, besides the values' own indices.
inline constexpr std::size_t kTimecode = kLiveLinkValueCount + 1;
inline constexpr std::size_t kCount = kLiveLinkValueCount + 2;

std::string_view trim(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::size_t column_meaning(std::string_view cell) {
  if (equal_ignoring_case(cell, "Timecode")) return kTimecode;
  if (equal_ignoring_case(cell, "BlendShapeCount")) return kCount;
  if (const std::size_t i = arkit_index(cell); i < kShapeColumns) return i;
  for (std::size_t i = 0; i < kAngleNames.size(); ++i)
    if (equal_ignoring_case(cell, kAngleNames[i])) return kShapeColumns + i;
  return kUnknown;
}

/// Cuts `text` at the first `separator`; returns what is before it.
std::string_view cut(std::string_view& text, char separator) {
  const std::size_t at = text.find(separator);
  const std::string_view front = text.substr(0, at);
  text = at == std::string_view::npos ? std::string_view() : text.substr(at + 1);
  return front;
}

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  line = trim(line);
  bool last = false;
  while (!last && cells.size() <= kMaxColumns) {
    last = line.find(',') == std::string_view::npos;
    cells.push_back(trim(cut(line, ',')));
  }
  if (last && cells.size() > 1 && cells.back().empty()) cells.pop_back();
  return cells;
}

std::optional<std::int32_t> whole_number(std::string_view text, std::int32_t most) {
  std::int32_t value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size() || value < 0 || value > most)
    return std::nullopt;
  return value;
}

std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || text.empty() || !(std::abs(value) <= kMaxValue))
    return std::nullopt;
  if (code == std::errc{}) return value;
  return std::nullopt;
}

/// Whether a file that ends here may have been cut in the middle of a number: with a further digit it is one.
bool begins_number(std::string_view text) {
  return !number(text) && number(std::string(text) + '0').has_value();
}

/// Columns in the order in which they are written.
const std::array<std::size_t, kLiveLinkValueCount>& written_order() {
  static const auto order = [] {
    std::array<std::size_t, kLiveLinkValueCount> indices{};
    const Profile& profile = arkit52(ArkitOrder::live_link_csv);
    for (std::size_t i = 0; i < kShapeColumns; ++i) indices[i] = arkit_index(profile.shapes[i]);
    for (std::size_t i = kShapeColumns; i < kLiveLinkValueCount; ++i) indices[i] = i;
    return indices;
  }();
  return order;
}

struct Header {
  std::vector<std::size_t> meaning;
  bool right_first = false;
};

Result<Header> parse_header(std::string_view line, std::string_view name,
                            std::vector<std::string>& warnings) {
  Header header;
  const auto cells = cells_of(line);
  if (cells.size() > kMaxColumns)
    return fail(ErrorCode::out_of_range, fmt::format("more than {} columns", kMaxColumns), std::string(name));
  std::array<std::size_t, kCount + 1> column{};  // 0: not seen; else its place + 1.
  std::vector<std::string_view> unknown;
  for (const std::string_view cell : cells) {
    const std::size_t meaning = column_meaning(cell);
    header.meaning.push_back(meaning);
    if (meaning == kUnknown) {
      unknown.push_back(cell);
      continue;
    }
    if (column[meaning] != 0)
      return fail(ErrorCode::malformed, fmt::format("the column {} stands there twice", excerpt(cell)),
                  fmt::format("{}, line 1", name));
    column[meaning] = header.meaning.size();
  }
  if (column[kTimecode] == 0)
    return fail(ErrorCode::malformed, "the first line names no Timecode column",
                fmt::format("{}, line 1", name), "is this a Live Link Face recording?");
  std::vector<std::string_view> missing;
  for (std::size_t i = 0; i < kShapeColumns; ++i)
    if (column[i] == 0) missing.push_back(arkit52().shapes[i]);
  if (missing.size() == kShapeColumns)
    return fail(ErrorCode::malformed, "the first line names no blendshape", fmt::format("{}, line 1", name),
                "is this a Live Link Face recording?");
  if (missing.size() == 1)
    warnings.push_back(fmt::format("the blendshape {} has no column and is taken as 0", missing.front()));
  else if (!missing.empty())
    warnings.push_back(fmt::format("{} blendshapes have no column and are taken as 0, {} first",
                                   missing.size(), missing.front()));
  if (unknown.size() == 1)
    warnings.push_back(fmt::format("the unknown column '{}' is left out", excerpt(unknown.front())));
  else if (!unknown.empty())
    warnings.push_back(
        fmt::format("{} unknown columns are left out, '{}' first", unknown.size(), excerpt(unknown.front())));
  const std::size_t left = column[arkit_index("eyeBlinkLeft")];
  const std::size_t right = column[arkit_index("eyeBlinkRight")];
  header.right_first = left != 0 && right != 0 && right < left;
  return header;
}

/// Indices of the longest strictly rising run of `time_s`, in order (patience sorting, O(n log n)).
std::vector<std::size_t> longest_rising(const std::vector<double>& time_s) {
  constexpr auto kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> tails;  // tails[k]: where the run of length k + 1 with the smallest end ends.
  std::vector<std::size_t> before(time_s.size(), kNone);
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    const auto at =
        std::ranges::lower_bound(tails, time_s[i], {}, [&](std::size_t tail) { return time_s[tail]; });
    if (at != tails.begin()) before[i] = *(at - 1);
    if (at == tails.end())
      tails.push_back(i);
    else if (time_s[i] < time_s[*at])  // Of rows with the same time the first stays.
      *at = i;
  }
  std::vector<std::size_t> run;
  for (std::size_t i = tails.empty() ? kNone : tails.back(); i != kNone; i = before[i]) run.push_back(i);
  std::ranges::reverse(run);
  return run;
}

LiveLinkRow row_of(const MotionFrame& frame, bool has_head, bool clamp_mouth_close) {
  LiveLinkRow row;
  row.timecode = timecode_at(frame.time_s);
  row.timecode_text = format_timecode(row.timecode);
  if (!frame.has_face) return row;
  const ArkitWeights arkit = arkit_from_ict(frame.weights, frame.tongue_out, clamp_mouth_close);
  row.values.assign(arkit.values.begin(), arkit.values.end());
  const Vec3 head = has_head ? livelink_from_head(frame.head) : Vec3::Zero();
  row.values.insert(row.values.end(), head.data(), head.data() + 3);
  const auto weight = [&](std::size_t k) { return static_cast<double>(frame.weights[k]); };
  row.values.push_back(kEyeTurnRadPerUnit * (weight(shape("eyeLookIn_L")) - weight(shape("eyeLookOut_L"))));
  row.values.push_back(kEyeTurnRadPerUnit * (weight(shape("eyeLookDown_L")) - weight(shape("eyeLookUp_L"))));
  row.values.push_back(0);
  row.values.push_back(kEyeTurnRadPerUnit * (weight(shape("eyeLookOut_R")) - weight(shape("eyeLookIn_R"))));
  row.values.push_back(kEyeTurnRadPerUnit * (weight(shape("eyeLookDown_R")) - weight(shape("eyeLookUp_R"))));
  row.values.push_back(0);
  return row;
}

}  // namespace

Result<Timecode> parse_timecode(std::string_view text) {
  const auto bad = [text](ErrorCode code) {
    return fail(code, fmt::format("'{}' is no time code such as 00:32:09:07.867", excerpt(text)));
  };
  std::string_view rest = text;
  const auto hour = whole_number(cut(rest, ':'), 99);
  const auto minute = whole_number(cut(rest, ':'), 59);
  // Drop-frame time codes set the frames off by a semicolon.
  const auto second = whole_number(cut(rest, rest.find(';') == std::string_view::npos ? ':' : ';'), 59);
  std::string_view fraction = rest;
  const auto frame = whole_number(cut(fraction, '.'), 239);
  if (!hour || !minute || !second || !frame) return bad(ErrorCode::malformed);
  std::int32_t milli = 0;
  std::int32_t unit = 100;
  for (const char c : fraction) {
    if (c < '0' || c > '9') return bad(ErrorCode::malformed);
    milli += unit * (c - '0');
    unit /= 10;
  }
  return Timecode{*hour, *minute, *second, *frame * 1000 + milli};
}

std::string format_timecode(const Timecode& t) {
  return fmt::format("{:02}:{:02}:{:02}:{:02}.{:03}", t.hour, t.minute, t.second, t.frame_milli / 1000,
                     t.frame_milli % 1000);
}

double timecode_seconds(const Timecode& t, int base) {
  const std::int64_t whole = (std::int64_t{t.hour} * 60 + t.minute) * 60 + t.second;
  return static_cast<double>(whole * base * 1000 + t.frame_milli) / (base * 1000.0);
}

Timecode timecode_at(double time_s) {
  constexpr std::int64_t kBase = 60;
  // In thousandths of a frame, rounded once, so that no second reads 59:60.
  const std::int64_t milli = std::llround(std::max(time_s, 0.0) * kBase * 1000);
  const std::int64_t second = milli / (kBase * 1000);
  return {static_cast<std::int32_t>(second / 3600 % 100), static_cast<std::int32_t>(second / 60 % 60),
          static_cast<std::int32_t>(second % 60), static_cast<std::int32_t>(milli % (kBase * 1000))};
}

Result<LiveLinkCsv> parse_livelink_csv(std::string_view text, std::string_view name) {
  LiveLinkCsv csv;
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  if (trim(text.substr(0, text.find('\n'))).empty())
    return fail(ErrorCode::truncated, "the first line is empty; a header is expected there",
                std::string(name));
  MIEN_TRY_ASSIGN(const Header header, parse_header(cut(text, '\n'), name, csv.warnings));
  csv.right_first = header.right_first;
  const std::size_t width = header.meaning.size();

  for (std::size_t line_number = 2; !text.empty(); ++line_number) {
    const bool ends = text.find('\n') != std::string_view::npos;
    const auto cells = cells_of(cut(text, '\n'));
    if (cells.size() == 1 && cells[0].empty()) continue;
    const auto where = [&] { return fmt::format("{}, line {}", name, line_number); };

    LiveLinkRow row;
    bool lost = cells.size() == 2 && width > 2;
    bool counts_none = false;
    std::optional<Error> error;
    for (std::size_t c = 0; c < std::min(cells.size(), width) && !error; ++c) {
      if (header.meaning[c] == kTimecode) {
        row.timecode_text = cells[c];
        if (auto timecode = parse_timecode(cells[c]))
          row.timecode = *timecode;
        else
          error = Error{timecode.error().code, timecode.error().what, where(), {}};
      } else if (header.meaning[c] == kCount) {
        const auto count = whole_number(cells[c], 1'000'000);
        if (!count) error = Error{ErrorCode::malformed, "the blendshape count is no count", where(), {}};
        counts_none = count == 0;
        lost = lost || counts_none;
      }
    }
    if (!error && cells.size() != width && !(lost && cells.size() == 2))
      error = Error{ErrorCode::malformed,
                    fmt::format("the row has {} cells, the header {}", cells.size(), width),
                    where(),
                    {}};
    // A recorder that was stopped in the middle of a row leaves a file that is good up to there: of that row
    // cells are missing, or the end of its last number. A row of two cells is whole only if it says that it
    // counts none.
    bool cut_short = !ends && cells.size() < width && !(cells.size() == 2 && counts_none);
    if (!error && !lost) {
      row.values.assign(kLiveLinkValueCount, 0.0);
      for (std::size_t c = 0; c < width && !error; ++c) {
        if (header.meaning[c] >= kLiveLinkValueCount) continue;
        if (const auto value = number(cells[c]))
          row.values[header.meaning[c]] = *value;
        else {
          cut_short = cut_short || (!ends && c + 1 == width && begins_number(cells[c]));
          error = Error{ErrorCode::out_of_range,
                        fmt::format("'{}' is no number within {}", excerpt(cells[c]), kMaxValue),
                        fmt::format("{}, column {}", where(), c + 1),
                        {}};
        }
      }
    }
    if (!error && row.timecode_text.empty())
      error = Error{ErrorCode::malformed, "the row has no time code", where(), {}};
    if (cut_short) {
      csv.warnings.push_back(fmt::format("the last row, line {}, is cut short and left out", line_number));
      break;
    }
    if (error) return std::unexpected(std::move(*error));
    csv.rows.push_back(std::move(row));
  }
  if (csv.rows.empty())
    return fail(ErrorCode::truncated, "there is no row below the header", std::string(name));
  return csv;
}

void append_livelink_header(std::string& out) {
  auto end = std::back_inserter(out);
  out += "Timecode,BlendShapeCount";
  for (std::size_t i = 0; i < kShapeColumns; ++i) {
    const std::string& shape_name = arkit52(ArkitOrder::live_link_csv).shapes[i];
    fmt::format_to(end, ",{}{}", static_cast<char>(shape_name[0] - 'a' + 'A'), shape_name.substr(1));
  }
  for (const std::string_view angle : kAngleNames) fmt::format_to(end, ",{}", angle);
  out += '\n';
}

void append_livelink_row(std::string_view timecode, std::span<const double> values, std::string& out) {
  auto end = std::back_inserter(out);
  fmt::format_to(end, "{},{}", timecode, values.empty() ? 0 : kLiveLinkValueCount);
  if (!values.empty())
    for (const std::size_t i : written_order()) fmt::format_to(end, ",{:.10f}", values[i]);
  out += '\n';
}

std::string format_livelink_csv(const LiveLinkCsv& csv) {
  std::string text;
  append_livelink_header(text);
  for (const LiveLinkRow& row : csv.rows) append_livelink_row(row.timecode_text, row.values, text);
  return text;
}

int timecode_base(const LiveLinkCsv& csv) {
  std::int32_t largest = 0;
  for (const LiveLinkRow& row : csv.rows) largest = std::max(largest, row.timecode.frame_milli / 1000);
  if (largest > 30 || largest < 21) return 60;
  return largest <= 23 ? 24 : largest == 24 ? 25 : 30;
}

LiveLinkMotion motion_from_livelink(const LiveLinkCsv& csv, std::string name) {
  LiveLinkMotion result;
  result.warnings = csv.warnings;
  Motion& motion = result.motion;
  motion.name = std::move(name);
  if (csv.rows.empty()) return result;

  const int base = timecode_base(csv);
  constexpr double kDay = 86400;
  std::vector<double> time_s;
  double days = 0;
  for (std::size_t i = 0; i < csv.rows.size(); ++i) {
    const Timecode& now = csv.rows[i].timecode;
    if (i > 0 && csv.rows[i - 1].timecode.hour == 23 && now.hour == 0) days += kDay;
    time_s.push_back(days + timecode_seconds(now, base));
  }
  const auto kept = longest_rising(time_s);
  if (kept.size() < csv.rows.size())
    result.warnings.push_back(
        fmt::format("{} rows with doubled or falling time codes are dropped", csv.rows.size() - kept.size()));
  result.start_s = time_s[kept.front()];
  std::vector<double> steps;
  for (const std::size_t i : kept) {
    const LiveLinkRow& row = csv.rows[i];
    MotionFrame& frame = motion.frames.emplace_back();
    frame.time_s = time_s[i] - time_s[kept.front()];
    if (motion.frames.size() > 1)
      steps.push_back(frame.time_s - motion.frames[motion.frames.size() - 2].time_s);
    frame.has_face = row.has_face();
    if (!frame.has_face) continue;
    ArkitWeights arkit;
    std::ranges::transform(row.values.begin(), row.values.begin() + kShapeColumns, arkit.values.begin(),
                           [](double v) { return static_cast<float>(v); });
    frame.weights = ict_from_arkit(arkit, &frame.tongue_out);
    const Vec3 angles(row.values[kShapeColumns], row.values[kShapeColumns + 1],
                      row.values[kShapeColumns + 2]);
    frame.head = head_from_livelink(angles);
    motion.has_head = motion.has_head || !angles.isZero(0);
  }
  if (!steps.empty()) result.rate_hz = 1 / upper_median(std::move(steps));
  return result;
}

LiveLinkCsv livelink_from_motion(const Motion& motion, bool clamp_mouth_close) {
  LiveLinkCsv csv;
  csv.rows.reserve(motion.frames.size());
  for (const MotionFrame& frame : motion.frames)
    csv.rows.push_back(row_of(frame, motion.has_head, clamp_mouth_close));
  return csv;
}

std::string format_livelink_csv(const Motion& motion) {
  std::string text;
  append_livelink_header(text);
  // Hours of rows are not copied while they grow: a row has at most a sign, two digits, a point, ten decimals
  // and a comma a value.
  text.reserve(text.size() + motion.frames.size() * (24 + 15 * kLiveLinkValueCount));
  for (const MotionFrame& frame : motion.frames) {
    const LiveLinkRow row = row_of(frame, motion.has_head, true);
    append_livelink_row(row.timecode_text, row.values, text);
  }
  return text;
}

Quat head_from_livelink(const Vec3& yaw_pitch_roll_rad) {
  // +X is the performer's left, +Y up, +Z forward: a positive turn about +Y looks left, about +X down, and
  // about +Z leans to the right.
  return canonical(Quat(Eigen::AngleAxisd(-yaw_pitch_roll_rad.x(), Vec3::UnitY()) *
                        Eigen::AngleAxisd(yaw_pitch_roll_rad.y(), Vec3::UnitX()) *
                        Eigen::AngleAxisd(yaw_pitch_roll_rad.z(), Vec3::UnitZ())));
}

Vec3 livelink_from_head(const Quat& q_world_head) {
  const Mat3 r = q_world_head.toRotationMatrix();
  // R = Ry(a) Rx(b) Rz(c): r12 = -sin b, r02 / r22 = tan a, r10 / r11 = tan c.
  const double pitch = std::asin(std::clamp(-r(1, 2), -1.0, 1.0));
  // Looking straight up or down, yaw and roll turn about the same axis: all of it is called yaw.
  if (std::abs(r(1, 2)) > 1 - 1e-12) return {-std::atan2(-r(2, 0), r(0, 0)), pitch, 0};
  return {-std::atan2(r(0, 2), r(2, 2)), pitch, std::atan2(r(1, 0), r(1, 1))};
}

Result<LiveLinkMotion> load_livelink(const std::filesystem::path& path) {
  // Four hours at 60 frames a second are 700 MB.
  constexpr std::size_t kMaxMotionBytes = std::size_t{1} << 30U;
  MIEN_TRY_ASSIGN(const std::string text, read_text(path, kMaxMotionBytes));
  MIEN_TRY_ASSIGN(const LiveLinkCsv csv, parse_livelink_csv(text, path.string()));
  LiveLinkMotion loaded = motion_from_livelink(csv, path.stem().string());
  if (std::ranges::none_of(loaded.motion.frames, &MotionFrame::has_face))
    return fail(ErrorCode::not_found, "the face is lost in every row", path.string());
  return loaded;
}

Result<Motion> load_motion(const std::filesystem::path& path, std::vector<std::string>* warnings) {
  MIEN_TRY_ASSIGN(LiveLinkMotion loaded, load_livelink(path));
  if (warnings != nullptr) *warnings = std::move(loaded.warnings);
  return std::move(loaded.motion);
}

}  // namespace mien::face
