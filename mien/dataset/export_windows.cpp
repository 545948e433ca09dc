#include "mien/dataset/export_windows.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "mien/core/excerpt.h"
#include "mien/core/files.h"
#include "mien/dataset/datasheet.h"
#include "mien/dataset/export_folder.h"
#include "mien/model/safetensors.h"

namespace mien::dataset {
namespace {

using ExportJson = nlohmann::ordered_json;

std::string json_text(const ExportJson& json) {
  // A file's name may be any bytes.
  return json.dump(-1, ' ', false, ExportJson::error_handler_t::replace);
}

/// Gathers the windows of one set, and writes a file whenever there are enough.
class SetWriter {
 public:
  SetWriter(const ExportRequest& request, const std::vector<std::string>& sensors, Split split,
            ExportFolder& folder)
      : request_(request), sensors_(sensors), split_(split), folder_(folder) {
    clear();
  }

  /// What windows that follow are of.
  void begin_take(const RecordedTake& take) {
    take_ = &take;
    take_place_ = kNone;
    line_places_.clear();
  }
  Result<void> add_window(const CountedStretch& stretch, std::size_t first) {
    const Sequence& sequence = stretch.sequence;
    const std::size_t n = sensors_.size();
    if (take_place_ == kNone) add_take();
    for (std::size_t f = first; f < first + request_.window; ++f) {
      append(condition_, std::span(sequence.values).subspan(7 * n * f, 7 * n));
      append(condition_, std::span(sequence.present).subspan(2 * n * f, 2 * n));
      append(weights_, std::span(sequence.weights).subspan(face::kShapeCount * f, face::kShapeCount));
      line_.push_back(line_place(stretch.line[f]));
    }
    of_take_.push_back(static_cast<float>(take_place_));
    begin_s_.push_back(static_cast<float>(to_seconds(stretch.begin - take_->first_frame) +
                                          static_cast<double>(first) / kFrameRateHz));
    ++set_.windows;
    const std::size_t numbers = condition_.size() + weights_.size() + line_.size() + 2 * of_take_.size();
    const bool room = numbers * sizeof(float) < request_.most_bytes && lines_.size() < kMostLinesAFile;
    return room ? Result<void>() : write();
  }
  void add_seconds(double seconds) { set_.seconds += seconds; }
  /// Writes what is left.
  Result<ExportedSplit> finish() {
    if (!of_take_.empty()) MIEN_TRY(write());
    return std::move(set_);
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  template <class T>
  static void append(std::vector<float>& to, std::span<const T> from) {
    to.insert(to.end(), from.begin(), from.end());
  }
  void add_take() {
    take_place_ = takes_.size();
    takes_.push_back({{"file", without_controls(take_->overview.path.filename().string())},
                      {"person", take_->overview.performer}});
  }
  /// Of one of the take's lines in this file.
  float line_place(std::int32_t line) {
    if (line < 0) return -1;
    const auto [place, fresh] = line_places_.emplace(line, lines_.size());
    if (fresh) {
      const session::RecordedLine& recorded = take_->lines[static_cast<std::size_t>(line)];
      lines_.push_back({{"take", take_place_},
                        {"name", excerpt(recorded.name, kNameLetters)},
                        {"block", excerpt(recorded.block, kNameLetters)},
                        {"emotion", excerpt(recorded.emotion, kNameLetters)},
                        {"language", excerpt(recorded.language, kNameLetters)}});
    }
    return static_cast<float>(place->second);
  }
  Result<void> write() {
    const std::size_t windows = of_take_.size();
    const std::size_t frames = request_.window;
    model::TensorFile file;
    file.metadata = {{"format", "mien windows 1"},
                     {"software", request_.software},
                     {"split", std::string(kSplitNames[static_cast<std::size_t>(split_)])},
                     {"rate_hz", fmt::format("{}", kFrameRateHz)},
                     {"window", fmt::format("{}", frames)},
                     {"stride", fmt::format("{}", request_.stride)},
                     {"sensors", json_text(sensors_)},
                     {"shapes", json_text(face::kShapeNames)},
                     {"takes", json_text(takes_)},
                     {"lines", json_text(lines_)}};
    const auto add = [&file](std::string name, std::vector<std::size_t> shape, std::vector<float>& values) {
      file.tensors.push_back({std::move(name), std::move(shape), std::move(values)});
    };
    add("condition", {windows, frames, 9 * sensors_.size()}, condition_);
    add("weights", {windows, frames, face::kShapeCount}, weights_);
    add("line", {windows, frames}, line_);
    add("take", {windows}, of_take_);
    add("begin_s", {windows}, begin_s_);
    std::string name(kSplitNames[static_cast<std::size_t>(split_)]);
    if (!set_.files.empty()) name += fmt::format("-{}", set_.files.size() + 1);
    name += ".safetensors";
    MIEN_TRY(write_file(folder_.path_of(name), model::write_safetensors(file)));
    set_.files.push_back(std::move(name));
    clear();
    return {};
  }
  /// A new file begins.
  void clear() {
    for (std::vector<float>* values : {&condition_, &weights_, &line_, &of_take_, &begin_s_}) *values = {};
    takes_ = lines_ = ExportJson::array();
    take_place_ = kNone;
    line_places_.clear();
  }

  /// Letters of a line's name or label. They all stand in the file's header, which has a limit.
  static constexpr std::size_t kNameLetters = 60;
  static constexpr std::size_t kMostLinesAFile = 50'000;

  const ExportRequest& request_;
  const std::vector<std::string>& sensors_;
  Split split_;
  ExportFolder& folder_;
  ExportedSplit set_;
  std::vector<float> condition_, weights_, line_, of_take_, begin_s_;
  ExportJson takes_, lines_;
  const RecordedTake* take_ = nullptr;
  std::size_t take_place_ = kNone;                   // In takes_.
  std::map<std::int32_t, std::size_t> line_places_;  // In lines_, by the place in the take's.
};

Result<void> check_request(const ExportRequest& request) {
  const auto wrong = [&request](std::string_view what, std::size_t is, std::size_t least) {
    return fail(ErrorCode::out_of_range,
                fmt::format("a {} of {} frames, not {} to {}", what, is, least, kLongestWindow),
                request.out.string());
  };
  if (request.window < 2 || request.window > kLongestWindow) return wrong("window", request.window, 2);
  if (request.stride < 1 || request.stride > kLongestWindow) return wrong("stride", request.stride, 1);
  return {};
}

}  // namespace

Result<Export> export_windows(const ExportRequest& request, const Progress& progress) {
  MIEN_TRY(check_request(request));
  MIEN_TRY_ASSIGN(const FoundTakes found, find_takes(request.folder, {}, progress));
  Export out;
  MIEN_TRY_ASSIGN(out.splits, read_splits(request.splits, found.people()));
  MIEN_TRY_ASSIGN(ExportFolder folder, ExportFolder::create(request.out, request.force));
  std::vector<SetWriter> writers;
  for (const Split split : {Split::train, Split::validation, Split::test})
    writers.emplace_back(request, found.sensors, split, folder);

  const auto add_take = [&](const RecordedTake& take) -> Result<void> {
    MIEN_TRY_ASSIGN(const Split split,
                    split_of(out.splits, take.overview.performer, request.splits.string()));
    SetWriter& writer = writers[static_cast<std::size_t>(split)];
    writer.begin_take(take);
    for (const CountedStretch& stretch : take.stretches) {
      std::size_t covered = 0, reached = 0;
      for (std::size_t first = 0; first + request.window <= stretch.sequence.frames;
           first += request.stride) {
        MIEN_TRY(writer.add_window(stretch, first));
        covered += first + request.window - std::max(first, reached);
        reached = first + request.window;
      }
      writer.add_seconds(static_cast<double>(covered) / kFrameRateHz);
      out.too_short_s += static_cast<double>(stretch.sequence.frames - covered) / kFrameRateHz;
    }
    return {};
  };
  MIEN_TRY_ASSIGN(out.dataset, read_dataset(found, progress, add_take));
  std::size_t windows = 0;
  for (std::size_t i = 0; i < writers.size(); ++i) {
    MIEN_TRY_ASSIGN(out.sets[i], writers[i].finish());
    windows += out.sets[i].windows;
  }
  if (windows == 0)
    return fail(ErrorCode::not_found,
                out.dataset.takes.empty()
                    ? "no take in it counts"
                    : fmt::format("nothing that counts is as long as a window of {} frames", request.window),
                request.folder.string(),
                out.dataset.takes.empty() ? "mien dataset says why" : "take a shorter --window");
  MIEN_TRY(write_file(folder.path_of(kDatasheetName), datasheet_of(request, out)));
  MIEN_TRY(folder.finish());
  return out;
}

}  // namespace mien::dataset
