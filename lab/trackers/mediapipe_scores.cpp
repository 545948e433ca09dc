#include "lab/trackers/mediapipe_scores.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "lab/trackers/tracker_curves.h"
#include "mien/core/ascii.h"
#include "mien/core/excerpt.h"

namespace mien::lab {
namespace {

using ScoreJson = nlohmann::json;

/// Deeper than any result of FaceLandmarker's: landmarks of faces are five.
constexpr int kMaxScoreDepth = 32;
/// Of one face in one frame.
constexpr std::size_t kMaxScores = 1024;

/// The float that is nearest to what is written: by way of a double it may be its neighbour.
float weight_in(std::string_view cell, double value) {
  float weight = 0;
  const auto [end, code] = std::from_chars(cell.data(), cell.data() + cell.size(), weight);
  return code == std::errc{} ? weight : static_cast<float>(value);
}

std::unexpected<Error> no_score(std::string_view written, const std::string& where) {
  return fail(ErrorCode::out_of_range,
              fmt::format("'{}' is no score within {}", excerpt(written), kMostTrackerWeight), where,
              "scores are 0 to 1 (divide percent by 100); leave the row out where there is none");
}

bool is_score(double value) {
  return std::isfinite(value) && std::abs(value) <= kMostTrackerWeight;
}

/// One frame's scores by their names, put into the curves' shapes.
class FrameScores {
 public:
  explicit FrameScores(CurveNames& names) : names_(names) {}

  Result<void> add(const std::string& name, double score, const std::string& where) {
    if (++count_ > kMaxScores)
      return fail(ErrorCode::out_of_range, fmt::format("a face has more than {} scores", kMaxScores), where);
    MIEN_TRY_ASSIGN(const std::span<const std::size_t> shapes, names_.shapes(name, where));
    if (!is_score(score)) return no_score(fmt::format("{}", score), where);
    for (const std::size_t k : shapes) {
      if (told_[k]) return fail(ErrorCode::malformed, fmt::format("{} is told twice", excerpt(name)), where);
      told_.set(k);
      weights_[k] = static_cast<float>(score);
    }
    return {};
  }
  [[nodiscard]] const ToldShapes& told() const { return told_; }
  [[nodiscard]] const face::BlendshapeWeights& weights() const { return weights_; }

 private:
  CurveNames& names_;
  ToldShapes told_;
  face::BlendshapeWeights weights_;
  std::size_t count_ = 0;
};

/// The first of these members that the object has.
const ScoreJson* member_of(const ScoreJson& object, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (const auto found = object.find(name); found != object.end()) return &*found;
  return nullptr;
}

Result<double> frame_time(const ScoreJson& frame, const std::string& where) {
  for (const std::string_view name : kScoreTimeColumns) {
    const auto found = frame.find(std::string(name));
    if (found == frame.end()) continue;
    if (!found->is_number()) return fail(ErrorCode::malformed, fmt::format("{} is no number", name), where);
    return found->get<double>() * (name == "time_s" ? 1.0 : 1e-3);
  }
  return fail(ErrorCode::malformed, "the frame has no time", where,
              "give each line timestamp_ms, milliseconds, or time_s");
}

Result<void> add_categories(const ScoreJson& list, FrameScores& scores, const std::string& where) {
  for (const ScoreJson& category : list) {
    const ScoreJson* name =
        category.is_object() ? member_of(category, {"category_name", "categoryName", "label"}) : nullptr;
    const ScoreJson* score = category.is_object() ? member_of(category, {"score"}) : nullptr;
    if (name == nullptr || !name->is_string() || score == nullptr || !score->is_number())
      return fail(ErrorCode::malformed, "a blendshape has no category_name or no score", where);
    MIEN_TRY(scores.add(name->get_ref<const std::string&>(), score->get<double>(), where));
  }
  return {};
}

/// What is told of the first face; none where there is no face.
Result<std::optional<FrameScores>> first_face(const ScoreJson& frame, CurveNames& names,
                                              const std::string& where) {
  const ScoreJson* faces = member_of(frame, {"face_blendshapes", "faceBlendshapes"});
  if (faces == nullptr || (!faces->is_array() && !faces->is_null()))
    return fail(ErrorCode::malformed, "the frame has no list face_blendshapes", where,
                "an empty list says that there is no face");
  if (faces->is_null() || faces->empty()) return std::optional<FrameScores>();
  const ScoreJson& face = faces->front();
  FrameScores scores(names);
  const ScoreJson* categories = face.is_object() ? member_of(face, {"categories"}) : nullptr;
  if (face.is_array() || (categories != nullptr && categories->is_array())) {
    MIEN_TRY(add_categories(categories != nullptr ? *categories : face, scores, where));
  } else if (face.is_object()) {
    for (const auto& [name, score] : face.items()) {
      if (!score.is_number())
        return fail(ErrorCode::malformed, fmt::format("{} is no number", excerpt(name)), where);
      MIEN_TRY(scores.add(name, score.get<double>(), where));
    }
  } else {
    return fail(ErrorCode::malformed, "a face is no list of blendshapes", where);
  }
  if (scores.told().none())
    return fail(ErrorCode::malformed, "a face has no blendshape", where,
                "an empty face_blendshapes says that there is no face");
  return std::optional(std::move(scores));
}

Result<ScoreJson> shallow_object(std::string_view line, const std::string& where) {
  bool deep = false;
  const auto shallow = [&deep](int depth, ScoreJson::parse_event_t, ScoreJson&) {
    deep = deep || depth > kMaxScoreDepth;
    return !deep;
  };
  ScoreJson object = ScoreJson::parse(line, shallow, false);
  if (deep || !object.is_object())
    return fail(ErrorCode::malformed, "the line is no JSON object", where, "write one frame a line");
  return object;
}

/// Which column of a table is what.
struct ScoreHeader {
  std::size_t time_cell = 0;
  double unit_s = 1;
  std::vector<std::vector<std::size_t>> shapes;  // Of each column; empty: passed over.
};

Result<ScoreHeader> score_header(std::string_view line, const std::string& name, TrackerCurves& curves) {
  const std::string where = name + ", line 1";
  const std::vector<std::string_view> cells = table_cells(line);
  if (cells.size() > kMaxTableColumns)
    return fail(ErrorCode::out_of_range, fmt::format("more than {} columns", kMaxTableColumns), where);
  ScoreHeader header;
  CurveNames names;
  bool has_time = false;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    std::vector<std::size_t>& shapes = header.shapes.emplace_back();
    const auto is = [cell = cells[c]](std::string_view what) { return equal_ignoring_case(cell, what); };
    if (std::ranges::any_of(kScoreTimeColumns, is)) {
      if (has_time) return fail(ErrorCode::malformed, "two columns are times", where, "keep one of them");
      has_time = true;
      header.time_cell = c;
      header.unit_s = is("time_s") ? 1.0 : 1e-3;
      continue;
    }
    if (is("frame")) continue;
    MIEN_TRY_ASSIGN(const std::span<const std::size_t> named, names.shapes(cells[c], where));
    for (const std::size_t k : named) {
      if (curves.told[k])
        return fail(ErrorCode::malformed, fmt::format("{} is told twice", excerpt(cells[c])), where);
      curves.told.set(k);
    }
    shapes.assign(named.begin(), named.end());
  }
  if (!has_time)
    return fail(ErrorCode::malformed, "no column is a time", where,
                "name it time_s, or timestamp_ms for milliseconds");
  if (curves.told.none()) return fail(ErrorCode::malformed, "no column is a shape", where);
  return header;
}

/// One row of a table.
Result<TrackerRow> score_row(const std::vector<std::string_view>& cells, const ScoreHeader& header,
                             const std::string& where) {
  if (cells.size() != header.shapes.size())
    return fail(ErrorCode::malformed,
                fmt::format("the row has {} cells, the header {}", cells.size(), header.shapes.size()),
                where);
  const std::optional<double> time = number_in(cells[header.time_cell]);
  if (!time) return fail(ErrorCode::malformed, "the row has no time", where);
  TrackerRow row{.time_s = *time * header.unit_s, .weights = face::BlendshapeWeights{}};
  std::size_t scores = 0, empty = 0;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    if (header.shapes[c].empty()) continue;
    ++scores;
    if (cells[c].empty()) {
      ++empty;
      continue;
    }
    const std::optional<double> score = number_in(cells[c]);
    if (!score || !is_score(*score)) return no_score(cells[c], fmt::format("{}, column {}", where, c + 1));
    for (const std::size_t k : header.shapes[c]) (*row.weights)[k] = weight_in(cells[c], *score);
  }
  if (empty == scores)
    row.weights.reset();
  else if (empty > 0)
    return fail(ErrorCode::malformed, "some scores of the row are empty", where,
                "leave all of them empty where there is no face");
  return row;
}

}  // namespace

Result<TrackerCurves> parse_mediapipe_lines(std::string_view text, const std::string& name) {
  TrackerCurves curves{.name = name, .rows = {}, .told = {}, .warnings = {}};
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  CurveNames names;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const bool ends = text.find('\n') != std::string_view::npos;
    const std::string_view line = trimmed_cell(cut_line(text));
    if (line.empty()) continue;
    const std::string where = fmt::format("{}, line {}", name, number);
    if (line.size() > kMaxTrackerLine)
      return fail(ErrorCode::out_of_range, fmt::format("the line is longer than {} bytes", kMaxTrackerLine),
                  where, "write one frame a line");
    const Result<ScoreJson> frame = shallow_object(line, where);
    if (!frame) {
      if (ends || curves.rows.empty()) return std::unexpected(frame.error());
      curves.warnings.push_back(fmt::format("the last frame, line {}, is cut short and left out", number));
      break;
    }
    TrackerRow row;
    MIEN_TRY_ASSIGN(row.time_s, frame_time(*frame, where));
    MIEN_TRY_ASSIGN(const std::optional<FrameScores> scores, first_face(*frame, names, where));
    if (scores) {
      if (curves.told.none()) curves.told = scores->told();
      if (curves.told != scores->told())
        return fail(ErrorCode::malformed,
                    fmt::format("the face has scores of {} shapes, or of others, where the frames before "
                                "have {}",
                                scores->told().count(), curves.told.count()),
                    where, "write the same names in every frame");
      row.weights = scores->weights();
    }
    MIEN_TRY(add_row(curves, row, where));
  }
  if (curves.rows.empty()) return fail(ErrorCode::truncated, "there is no frame in it", name);
  return curves;
}

Result<TrackerCurves> parse_scores_csv(std::string_view text, const std::string& name) {
  TrackerCurves curves{.name = name, .rows = {}, .told = {}, .warnings = {}};
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  MIEN_TRY_ASSIGN(const ScoreHeader header, score_header(cut_line(text), name, curves));
  for (std::size_t number = 2; !text.empty(); ++number) {
    const bool ends = text.find('\n') != std::string_view::npos;
    const std::string_view line = cut_line(text);
    if (trimmed_cell(line).empty()) continue;
    const std::string where = fmt::format("{}, line {}", name, number);
    const Result<TrackerRow> row = score_row(table_cells(line), header, where);
    if (!row) {
      if (ends || curves.rows.empty()) return std::unexpected(row.error());
      curves.warnings.push_back(fmt::format("the last row, line {}, is cut short and left out", number));
      break;
    }
    MIEN_TRY(add_row(curves, *row, where));
  }
  if (curves.rows.empty()) return fail(ErrorCode::truncated, "there is no row below the header", name);
  return curves;
}

std::string format_scores_csv(const TrackerCurves& curves) {
  std::string out = "time_s";
  auto end = std::back_inserter(out);
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (curves.told[k]) fmt::format_to(end, ",{}", face::kShapeNames[k]);
  out += '\n';
  for (const TrackerRow& row : curves.rows) {
    fmt::format_to(end, "{}", row.time_s);
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      if (!curves.told[k]) continue;
      if (row.weights)
        fmt::format_to(end, ",{}", (*row.weights)[k]);
      else
        out += ',';
    }
    out += '\n';
  }
  return out;
}

}  // namespace mien::lab
