#include "lab/trackers/openseeface_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "lab/trackers/tracker_curves.h"
#include "mien/core/ascii.h"
#include "mien/core/bytes.h"
#include "mien/core/excerpt.h"

namespace mien::lab {
namespace {

/// Features are within -1 and 1 and eyes within 0 and 1; what is beyond this is something else.
constexpr double kMostFeature = 100;
// Where things stand in a block (docs/reference/tracker_curves.md).
constexpr std::size_t kBlockTimeAt = 0, kBlockIdAt = 8, kBlockEyesAt = 20, kBlockSuccessAt = 28;
constexpr std::size_t kBlockFeaturesAt = kOpenSeeFaceBlockBytes - sizeof(float) * kOpenSeeFeatureCount;

/// Rows have two points more in the picture and four in space than the header names, three numbers each.
constexpr std::size_t kUnnamedCells = 3 * 2 + 3 * 4;

/// One face in one frame of a recording.
struct SeenBlock {
  double time_s = 0;
  std::int64_t id = 0;
  bool success = false;
  OpenSeeFace face;
};

Result<void> check_numbers(const SeenBlock& block, const std::string& where) {
  const auto wrong = [](float value) { return !(std::abs(value) <= kMostFeature); };
  if (!std::isfinite(block.time_s)) return fail(ErrorCode::out_of_range, "the time is no number", where);
  if (!block.success) return {};  // Its other numbers mean nothing.
  if (wrong(block.face.right_open) || wrong(block.face.left_open))
    return fail(ErrorCode::out_of_range, fmt::format("an eye's opening is no number within {}", kMostFeature),
                where, "is this a recording of OpenSeeFace?");
  for (std::size_t i = 0; i < kOpenSeeFeatureCount; ++i)
    if (wrong(block.face.features[i]))
      return fail(ErrorCode::out_of_range,
                  fmt::format("{} is no number within {}", kOpenSeeFeatureNames[i], kMostFeature), where,
                  "is this a recording of OpenSeeFace?");
  return {};
}

/// Blocks of one face, by the lowest id.
Result<void> add_blocks(const std::vector<SeenBlock>& blocks, const char* unit, TrackerCurves& curves) {
  std::int64_t id = std::numeric_limits<std::int64_t>::max();
  for (const SeenBlock& block : blocks) id = std::min(id, block.id);
  bool others = false;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const SeenBlock& block = blocks[b];
    others = others || block.id != id;
    if (block.id != id) continue;
    TrackerRow row{.time_s = block.time_s, .weights = {}};
    if (block.success) row.weights = weights_of(block.face);
    MIEN_TRY(add_row(curves, row, fmt::format("{}, {} {}", curves.name, unit, b + 1)));
  }
  if (others)
    curves.warnings.push_back(fmt::format("there are several faces: the one with id {} is taken", id));
  return {};
}

std::optional<bool> log_truth(std::string_view cell) {
  if (equal_ignoring_case(cell, "True") || cell == "1") return true;
  if (equal_ignoring_case(cell, "False") || cell == "0") return false;
  return std::nullopt;
}

struct LogHeader {
  std::size_t columns = 0;
  std::size_t time = 0, id = 0, right = 0, left = 0, success = 0;
  bool features = false;
};

Result<LogHeader> log_header(std::string_view line, const std::string& name) {
  const std::string where = name + ", line 1";
  const std::vector<std::string_view> cells = table_cells(line);
  if (cells.size() > kMaxTableColumns)
    return fail(ErrorCode::out_of_range, fmt::format("more than {} columns", kMaxTableColumns), where);
  LogHeader header{.columns = cells.size()};
  const std::array<std::pair<std::string_view, std::size_t*>, 5> wanted = {{{"Time", &header.time},
                                                                            {"FaceID", &header.id},
                                                                            {"RightOpen", &header.right},
                                                                            {"LeftOpen", &header.left},
                                                                            {"Success3D", &header.success}}};
  for (const auto& [column, place] : wanted) {
    const std::string_view sought = column;
    const auto found = std::ranges::find_if(
        cells, [sought](std::string_view cell) { return equal_ignoring_case(cell, sought); });
    if (found == cells.end())
      return fail(ErrorCode::malformed, fmt::format("the first line names no {} column", column), where,
                  "is this what OpenSeeFace writes with --log-data?");
    *place = static_cast<std::size_t>(found - cells.begin());
  }
  header.features =
      cells.size() > kOpenSeeFeatureCount &&
      std::equal(kOpenSeeFeatureNames.begin(), kOpenSeeFeatureNames.end(),
                 cells.end() - static_cast<std::ptrdiff_t>(kOpenSeeFeatureCount), equal_ignoring_case);
  return header;
}

Result<SeenBlock> log_row(const std::vector<std::string_view>& cells, const LogHeader& header,
                          const std::string& where) {
  if (cells.size() != header.columns && cells.size() != header.columns + kUnnamedCells)
    return fail(ErrorCode::malformed,
                fmt::format("the row has {} cells, where {} or {} are expected", cells.size(), header.columns,
                            header.columns + kUnnamedCells),
                where);
  const auto number = [&](std::size_t c, const char* what) -> Result<double> {
    const std::optional<double> value = number_in(cells[c]);
    if (!value)
      return fail(ErrorCode::malformed, fmt::format("{} is '{}', no number", what, excerpt(cells[c])), where);
    return *value;
  };
  SeenBlock block;
  MIEN_TRY_ASSIGN(block.time_s, number(header.time, "Time"));
  MIEN_TRY_ASSIGN(const double id, number(header.id, "FaceID"));
  if (!(std::abs(id) <= std::numeric_limits<std::int32_t>::max()))
    return fail(ErrorCode::out_of_range, "FaceID is no face's number", where);
  block.id = static_cast<std::int64_t>(id);
  MIEN_TRY_ASSIGN(const double right, number(header.right, "RightOpen"));
  MIEN_TRY_ASSIGN(const double left, number(header.left, "LeftOpen"));
  block.face.right_open = static_cast<float>(right);
  block.face.left_open = static_cast<float>(left);
  const std::optional<bool> success = log_truth(cells[header.success]);
  if (!success) return fail(ErrorCode::malformed, "Success3D is neither True nor False", where);
  block.success = *success;
  for (std::size_t i = 0; header.features && i < kOpenSeeFeatureCount; ++i) {
    MIEN_TRY_ASSIGN(const double value,
                    number(cells.size() - kOpenSeeFeatureCount + i, kOpenSeeFeatureNames[i].data()));
    block.face.features[i] = static_cast<float>(value);
  }
  MIEN_TRY(check_numbers(block, where));
  return block;
}

ToldShapes shapes_called(std::initializer_list<std::size_t> shapes) {
  ToldShapes out;
  for (const std::size_t k : shapes) out.set(k);
  return out;
}

}  // namespace

const ToldShapes& openseeface_lids() {
  static const ToldShapes lids = shapes_called({face::shape("eyeBlink_L"), face::shape("eyeBlink_R")});
  return lids;
}

const ToldShapes& openseeface_told() {
  static const ToldShapes told =
      openseeface_lids() |
      shapes_called({face::shape("browInnerUp_L"), face::shape("browInnerUp_R"), face::shape("browOuterUp_L"),
                     face::shape("browOuterUp_R"), face::shape("browDown_L"), face::shape("browDown_R"),
                     face::shape("jawOpen"), face::shape("mouthSmile_L"), face::shape("mouthSmile_R"),
                     face::shape("mouthFrown_L"), face::shape("mouthFrown_R"), face::shape("mouthStretch_L"),
                     face::shape("mouthStretch_R"), face::shape("mouthPucker")});
  return told;
}

face::BlendshapeWeights weights_of(const OpenSeeFace& face) {
  using enum OpenSeeFeature;
  const auto up = [](float value) { return std::clamp(value, 0.0F, 1.0F); };
  face::BlendshapeWeights out;
  out[face::shape("eyeBlink_L")] = up(1 - face.left_open);
  out[face::shape("eyeBlink_R")] = up(1 - face.right_open);
  out[face::shape("browInnerUp_L")] = out[face::shape("browOuterUp_L")] = up(face[eyebrow_updown_l]);
  out[face::shape("browInnerUp_R")] = out[face::shape("browOuterUp_R")] = up(face[eyebrow_updown_r]);
  out[face::shape("browDown_L")] = up(-face[eyebrow_updown_l]);
  out[face::shape("browDown_R")] = up(-face[eyebrow_updown_r]);
  out[face::shape("jawOpen")] = up(face[mouth_open]);
  out[face::shape("mouthSmile_L")] = up(-face[mouth_corner_updown_l]);
  out[face::shape("mouthSmile_R")] = up(-face[mouth_corner_updown_r]);
  out[face::shape("mouthFrown_L")] = up(face[mouth_corner_updown_l]);
  out[face::shape("mouthFrown_R")] = up(face[mouth_corner_updown_r]);
  out[face::shape("mouthStretch_L")] = out[face::shape("mouthStretch_R")] = up(face[mouth_wide]);
  out[face::shape("mouthPucker")] = up(-face[mouth_wide]);
  return out;
}

Result<TrackerCurves> parse_openseeface_blocks(std::span<const std::byte> bytes, const std::string& name) {
  TrackerCurves curves{.name = name, .rows = {}, .told = openseeface_told(), .warnings = {}};
  if (bytes.size() < kOpenSeeFaceBlockBytes)
    return fail(
        ErrorCode::truncated,
        fmt::format("it has {} bytes, a block of OpenSeeFace {}", bytes.size(), kOpenSeeFaceBlockBytes),
        name);
  if (bytes.size() % kOpenSeeFaceBlockBytes != 0)
    curves.warnings.emplace_back("the last block is cut short and left out");
  const std::size_t count = bytes.size() / kOpenSeeFaceBlockBytes;
  if (count > kMaxTrackerRows)
    return fail(ErrorCode::out_of_range, fmt::format("there are more than {} blocks", kMaxTrackerRows), name,
                "cut the recording into parts");
  std::vector<SeenBlock> blocks;
  blocks.reserve(count);
  for (std::size_t b = 0; b < count; ++b) {
    const auto whole = bytes.subspan(b * kOpenSeeFaceBlockBytes, kOpenSeeFaceBlockBytes);
    const std::string where = fmt::format("{}, block {}", name, b + 1);
    SeenBlock& block = blocks.emplace_back();
    block.time_s = ByteReader(whole.subspan(kBlockTimeAt)).little<double>();
    block.id = ByteReader(whole.subspan(kBlockIdAt)).little<std::int32_t>();
    ByteReader eyes(whole.subspan(kBlockEyesAt));
    block.face.right_open = eyes.little<float>();
    block.face.left_open = eyes.little<float>();
    const auto success = static_cast<std::uint8_t>(whole[kBlockSuccessAt]);
    if (success > 1)
      return fail(ErrorCode::malformed, fmt::format("success is {}, neither 0 nor 1", success), where,
                  "is this a recording of OpenSeeFace, from the first packet on?");
    block.success = success == 1;
    ByteReader features(whole.subspan(kBlockFeaturesAt));
    for (float& value : block.face.features) value = features.little<float>();
    MIEN_TRY(check_numbers(block, where));
  }
  MIEN_TRY(add_blocks(blocks, "block", curves));
  return curves;
}

Result<TrackerCurves> parse_openseeface_csv(std::string_view text, const std::string& name) {
  TrackerCurves curves{.name = name, .rows = {}, .told = {}, .warnings = {}};
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  MIEN_TRY_ASSIGN(const LogHeader header, log_header(cut_line(text), name));
  curves.told = header.features ? openseeface_told() : openseeface_lids();
  std::vector<SeenBlock> blocks;
  for (std::size_t number = 2; !text.empty(); ++number) {
    const bool ends = text.find('\n') != std::string_view::npos;
    const std::string_view line = cut_line(text);
    if (trimmed_cell(line).empty()) continue;
    const Result<SeenBlock> row =
        log_row(table_cells(line), header, fmt::format("{}, line {}", name, number));
    if (!row) {
      if (ends || blocks.empty()) return std::unexpected(row.error());
      curves.warnings.push_back(fmt::format("the last row, line {}, is cut short and left out", number));
      break;
    }
    if (blocks.size() == kMaxTrackerRows)
      return fail(ErrorCode::out_of_range, fmt::format("there are more than {} rows", kMaxTrackerRows), name,
                  "cut the recording into parts");
    blocks.push_back(*row);
  }
  if (blocks.empty()) return fail(ErrorCode::truncated, "there is no row below the header", name);
  MIEN_TRY(add_blocks(blocks, "face", curves));
  return curves;
}

std::vector<std::byte> openseeface_block(double time_s, std::int32_t id, bool success,
                                         const OpenSeeFace& face) {
  ByteWriter block;
  block.little(time_s);
  block.little(id);
  block.little(std::uint64_t{0});  // The picture's size.
  block.little(face.right_open);
  block.little(face.left_open);
  block.little(success ? std::uint8_t{1} : std::uint8_t{0});
  block.append(std::vector<std::byte>(kBlockFeaturesAt - kBlockSuccessAt - 1));
  for (const float value : face.features) block.little(value);
  return block.release();
}

}  // namespace mien::lab
