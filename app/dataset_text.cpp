#include "app/dataset_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "app/command.h"

namespace mien::app {
namespace {

using dataset::LabelAmounts;
using dataset::RecordedDataset;
using dataset::TakeOverview;
using dataset::TakeSeconds;
using dataset::TakeTotals;

TakeTotals totals_of(const RecordedDataset& dataset, const dataset::RecordedPerson& person) {
  TakeTotals totals;
  for (const std::size_t place : person.takes) totals.add(dataset.takes[place]);
  return totals;
}

double in_minutes(double seconds) {
  return seconds / 60;
}

std::string file_name(const std::filesystem::path& path) {
  return one_line(path.filename().string(), 40);
}

void print_people(const RecordedDataset& dataset) {
  fmt::print("\n{:<24}{:>7}{:>8}{:>8}{:>8}{:>8}{:>8}\n", "person", "takes", "min", "of", "lines", "poor",
             "sound");
  for (const dataset::RecordedPerson& person : dataset.people) {
    const TakeTotals totals = totals_of(dataset, person);
    fmt::print("{:<24}{:>7}{:>8.1f}{:>8.1f}{:>8}{:>8}{:>8.1f}\n", one_line(person.name, 23),
               person.takes.size(), in_minutes(totals.seconds.counted), in_minutes(totals.seconds.all()),
               totals.good_lines, totals.poor_lines, in_minutes(totals.sound_s));
  }
}

void print_takes(const RecordedDataset& dataset) {
  fmt::print("\n{:<24}{:<16}{:>7}{:>7}  {:<6}{:>10}{:>7}{:>8}{:>11}\n", "take", "person", "min", "of",
             "truth", "offset ms", "+- ms", "ppm", "agreement");
  for (const TakeOverview& take : dataset.takes) {
    fmt::print("{:<24}{:<16}{:>7.1f}{:>7.1f}  {}", one_line(take.path.filename().string(), 23),
               one_line(take.performer, 15), in_minutes(take.seconds.counted), in_minutes(take.seconds.all()),
               take.sync ? "phone" : "own");
    if (take.sync) {
      const phone::TimeAlignment& at = take.sync->alignment;
      fmt::print("{:>11.1f}{:>7.1f}{:>+8.1f}{:>11.2f}", 1e3 * at.offset_s, 1e3 * at.offset_sigma_s,
                 at.drift_ppm, at.agreement);
    }
    fmt::print("{}\n", take.finished ? "" : "  cut off, or still recording");
  }
}

/// Those of takes that are left out too: they are of somebody's face, whatever becomes of the take.
void print_videos(const RecordedDataset& dataset) {
  bool first = true;
  const auto print = [&first](const std::vector<dataset::TakeVideo>& videos) {
    for (const dataset::TakeVideo& video : videos) {
      if (std::exchange(first, false)) fmt::print("\n{:<40}{:>8}\n", "video beside the takes", "MB");
      fmt::print("{:<40}{:>8.1f}\n", one_line(video.file, 39), static_cast<double>(video.bytes) / 1e6);
    }
  };
  for (const TakeOverview& take : dataset.takes) print(take.videos);
  for (const dataset::LeftOutTake& take : dataset.left_out) print(take.videos);
}

void print_labels(std::string_view kind, const LabelAmounts& amounts) {
  constexpr std::size_t kLabelsShown = 40;
  if (amounts.empty()) return;
  fmt::print("\n{:<24}{:>7}{:>8}\n", kind, "lines", "min");
  std::size_t shown = 0;
  for (const auto& [label, amount] : amounts)
    if (shown++ < kLabelsShown)
      fmt::print("{:<24}{:>7}{:>8.1f}\n", one_line(label, 23), amount.lines, in_minutes(amount.seconds));
  if (shown > kLabelsShown) fmt::print("and {} more\n", shown - kLabelsShown);
}

void print_shapes(const RecordedDataset& dataset) {
  constexpr std::size_t kColumns = 3;
  constexpr std::size_t kRows = (face::kShapeCount + kColumns - 1) / kColumns;
  fmt::print("\n");
  for (std::size_t column = 0; column < kColumns; ++column)
    fmt::print("{}{:<18}{:>5}{:>6}", column == 0 ? "" : "   ", "shape", "1 %", "99 %");
  for (std::size_t row = 0; row < kRows; ++row) {
    fmt::print("\n");
    for (std::size_t k = row; k < face::kShapeCount; k += kRows)
      fmt::print("{}{:<18}{:>5.2f}{:>6.2f}", k == row ? "" : "   ", face::kShapeNames[k],
                 dataset.ranges[k].low, dataset.ranges[k].high);
  }
  fmt::print("\n");
}

void print_left_out(const RecordedDataset& dataset, const TakeSeconds& seconds) {
  if (!dataset.takes.empty()) {
    const std::vector<std::pair<std::string_view, double>> reasons = {
        {"no face was told", seconds.without_face},
        {"before the calibration was over", seconds.before_calibration},
        {"in lines that were poor", seconds.poor},
        {"no sensor was there", seconds.unfelt},
        {"less than two seconds between these", seconds.brief}};
    fmt::print("\n{:<40}{:>7}\n", "left out of these takes", "min");
    for (const auto& [why, spent_s] : reasons) fmt::print("{:<40}{:>7.1f}\n", why, in_minutes(spent_s));
  }
  if (!dataset.left_out.empty()) fmt::print("\ntakes left out\n");
  for (const dataset::LeftOutTake& take : dataset.left_out)
    fmt::print("{}: {}\n", file_name(take.path), one_line(take.why, 400));
}

Json json_of_seconds(const TakeSeconds& seconds) {
  return {{"counted_s", seconds.counted},
          {"without_face_s", seconds.without_face},
          {"before_calibration_s", seconds.before_calibration},
          {"poor_s", seconds.poor},
          {"without_sensor_s", seconds.unfelt},
          {"brief_s", seconds.brief}};
}

Json json_of_labels(const LabelAmounts& amounts) {
  Json json = Json::object();
  for (const auto& [label, amount] : amounts)
    json[label] = {{"lines", amount.lines}, {"seconds", amount.seconds}};
  return json;
}

void add_totals(const TakeTotals& totals, Json& to) {
  to["seconds"] = json_of_seconds(totals.seconds);
  to["sound_s"] = totals.sound_s;
  to["good_lines"] = totals.good_lines;
  to["poor_lines"] = totals.poor_lines;
  to["blocks"] = json_of_labels(totals.blocks);
  to["emotions"] = json_of_labels(totals.emotions);
  to["languages"] = json_of_labels(totals.languages);
}

Json json_of_shapes(const std::array<dataset::ShapeRange, face::kShapeCount>& ranges) {
  Json json = Json::object();
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    json[std::string(face::kShapeNames[k])] = {ranges[k].low, ranges[k].high};
  return json;
}

Json json_of_videos(const std::vector<dataset::TakeVideo>& videos) {
  Json json = Json::array();
  for (const dataset::TakeVideo& video : videos)
    json.push_back({{"file", video.file}, {"bytes", video.bytes}});
  return json;
}

Json json_of_take(const TakeOverview& take) {
  Json json;
  json["file"] = take.path.filename().string();
  json["performer"] = take.performer;
  json["finished"] = take.finished;
  json["rig"] = take.rig;
  json["created_utc"] = take.created_utc;
  json["consent"] = take.consent ? Json{{"recorded_by", take.consent->recorded_by},
                                        {"purpose", take.consent->purpose},
                                        {"sound", take.consent->sound},
                                        {"video", take.consent->video}}
                                 : Json();
  json["videos"] = json_of_videos(take.videos);
  json["truth"] = take.sync ? "phone" : "own";
  json["sync"] = Json();
  if (take.sync) {
    const phone::TimeAlignment& at = take.sync->alignment;
    json["sync"] = {{"offset_ms", 1e3 * at.offset_s},     {"offset_sigma_ms", 1e3 * at.offset_sigma_s},
                    {"drift_ppm", at.drift_ppm},          {"drift_sigma_ppm", at.drift_sigma_ppm},
                    {"agreement", at.agreement},          {"overlap_s", at.overlap_s},
                    {"left_out_s", take.sync->left_out_s}};
  }
  TakeTotals totals;
  totals.add(take);
  add_totals(totals, json);
  json["shapes"] = json_of_shapes(take.ranges);
  return json;
}

}  // namespace

void print_dataset(const RecordedDataset& dataset) {
  const TakeTotals totals = dataset.totals();
  fmt::print("{}: {} people, {} takes, {:.1f} min that count of {:.1f}; takes left out: {}\n",
             one_line(dataset.folder.string()), dataset.people.size(), dataset.takes.size(),
             in_minutes(totals.seconds.counted), in_minutes(totals.seconds.all()), dataset.left_out.size());
  if (!dataset.takes.empty()) {
    print_people(dataset);
    print_takes(dataset);
    print_labels("block", totals.blocks);
    print_labels("emotion", totals.emotions);
    print_labels("language", totals.languages);
    print_shapes(dataset);
  }
  print_left_out(dataset, totals.seconds);
  print_videos(dataset);
}

Json json_of(const RecordedDataset& dataset) {
  Json json;
  json["folder"] = dataset.folder.string();
  json["sensors"] = dataset.sensors;
  add_totals(dataset.totals(), json);
  json["shapes"] = json_of_shapes(dataset.ranges);
  json["people"] = Json::array();
  for (const dataset::RecordedPerson& person : dataset.people) {
    Json one{{"name", person.name}, {"takes", person.takes.size()}};
    add_totals(totals_of(dataset, person), one);
    json["people"].push_back(std::move(one));
  }
  json["takes"] = Json::array();
  for (const TakeOverview& take : dataset.takes) json["takes"].push_back(json_of_take(take));
  json["left_out"] = Json::array();
  for (const dataset::LeftOutTake& take : dataset.left_out)
    json["left_out"].push_back({{"file", take.path.filename().string()},
                                {"performer", take.performer.empty() ? Json() : Json(take.performer)},
                                {"why", take.why},
                                {"videos", json_of_videos(take.videos)}});
  return json;
}

Json json_of(const dataset::Splits& splits) {
  Json json;
  for (std::size_t i = 0; i < dataset::kSplitNames.size(); ++i)
    json[std::string(dataset::kSplitNames[i])] = splits.people[i];
  return json;
}

void print_export(const dataset::Export& exported) {
  fmt::print("{:<12}{:>8}{:>9}{:>8}  files\n", "set", "people", "windows", "min");
  for (std::size_t i = 0; i < dataset::kSplitNames.size(); ++i) {
    const dataset::ExportedSplit& set = exported.sets[i];
    fmt::print("{:<12}{:>8}{:>9}{:>8.1f}  {}\n", dataset::kSplitNames[i], exported.splits.people[i].size(),
               set.windows, in_minutes(set.seconds),
               set.files.empty() ? "none" : fmt::format("{}", fmt::join(set.files, ", ")));
  }
  fmt::print("{:.1f} min are in no window; takes left out: {}\n", in_minutes(exported.too_short_s),
             exported.dataset.left_out.size());
}

Json json_of(const dataset::Export& exported) {
  Json json;
  json["folder"] = exported.dataset.folder.string();
  json["sets"] = Json::object();
  for (std::size_t i = 0; i < dataset::kSplitNames.size(); ++i) {
    const dataset::ExportedSplit& set = exported.sets[i];
    json["sets"][std::string(dataset::kSplitNames[i])] = {{"people", exported.splits.people[i]},
                                                          {"windows", set.windows},
                                                          {"seconds", set.seconds},
                                                          {"files", set.files}};
  }
  json["in_no_window_s"] = exported.too_short_s;
  json["left_out"] = exported.dataset.left_out.size();
  return json;
}

}  // namespace mien::app
