#include "mien/dataset/recorded_dataset.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <system_error>
#include <utility>

#include "mien/core/excerpt.h"

namespace mien::dataset {
namespace {

namespace fs = std::filesystem;

/// The folder's takes, by name.
Result<std::vector<fs::path>> take_files(const fs::path& folder) {
  std::error_code code;
  if (!fs::is_directory(folder, code))
    return fail(ErrorCode::not_found, "there is no such folder", folder.string(),
                "name a folder with takes in it");
  fs::directory_iterator at(folder, code);
  if (code) return fail(ErrorCode::io, code.message(), folder.string());
  std::vector<fs::path> files;
  while (at != fs::directory_iterator()) {
    const fs::path& path = at->path();
    std::error_code unknown;
    if (path.extension() == ".mien" && !fs::is_directory(path, unknown)) files.push_back(path);
    if (files.size() > kMostTakes)
      return fail(ErrorCode::out_of_range, fmt::format("it holds more than {} takes", kMostTakes),
                  folder.string(), "divide it into several folders");
    at.increment(code);
    if (code) return fail(ErrorCode::io, code.message(), folder.string());
  }
  if (files.empty())
    return fail(ErrorCode::not_found, "there is no take (*.mien) in this folder", folder.string(),
                "record one, or name the folder of a dataset");
  std::ranges::sort(files);
  return files;
}

LeftOutTake left_out_by(const fs::path& path, std::string performer, Error error) {
  return {path, std::move(performer), error.code, std::move(error.what), videos_beside(path)};
}

/// The sensors that most takes have.
std::vector<std::string> usual_sensors(const std::vector<TakeIdentity>& takes) {
  std::map<std::vector<std::string>, std::size_t> counts;
  for (const TakeIdentity& take : takes) ++counts[take.sensors];
  std::vector<std::string> usual;
  std::size_t most = 0;
  for (const TakeIdentity& take : takes)
    if (counts[take.sensors] > most) {
      most = counts[take.sensors];
      usual = take.sensors;
    }
  return usual;
}

}  // namespace

std::string LeftOutTake::sentence() const {
  return fmt::format("{}: {}", path.filename().string(), why);
}

std::vector<std::string> FoundTakes::people() const {
  std::vector<std::string> names;
  for (const Take& take : takes) names.push_back(take.performer);
  for (const LeftOutTake& take : left_out)
    if (!take.performer.empty()) names.push_back(take.performer);
  std::ranges::sort(names);
  const auto same = std::ranges::unique(names);
  names.erase(same.begin(), same.end());
  return names;
}

TakeTotals RecordedDataset::totals() const {
  TakeTotals totals;
  for (const TakeOverview& take : takes) totals.add(take);
  return totals;
}

Result<FoundTakes> find_takes(const fs::path& folder, std::vector<std::string> sensors,
                              const Progress& progress) {
  MIEN_TRY_ASSIGN(const std::vector<fs::path> files, take_files(folder));
  FoundTakes found{folder, std::move(sensors), {}, {}};
  std::vector<TakeIdentity> identities;
  std::vector<fs::path> paths;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!progress(static_cast<double>(i) / static_cast<double>(files.size()), "looking for takes"))
      return fail(ErrorCode::cancelled, "stopped", folder.string());
    const Result<take::Take> take = take::Take::open(files[i]);
    Result<TakeIdentity> identity =
        take ? identify_take(*take) : Result<TakeIdentity>(std::unexpected(take.error()));
    if (!identity) {
      found.left_out.push_back(left_out_by(files[i], {}, std::move(identity).error()));
      continue;
    }
    identity->part.reset();  // Lines may be long, and takes many.
    identities.push_back(*std::move(identity));
    paths.push_back(files[i]);
  }
  if (found.sensors.empty()) found.sensors = usual_sensors(identities);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    TakeIdentity& take = identities[i];
    if (take.sensors == found.sensors) {
      found.takes.push_back({paths[i], std::move(take.performer)});
      continue;
    }
    std::vector<std::string> more, fewer;
    for (const std::string& name : take.sensors)
      if (std::ranges::find(found.sensors, name) == found.sensors.end()) more.push_back(name);
    for (const std::string& name : found.sensors)
      if (std::ranges::find(take.sensors, name) == take.sensors.end()) fewer.push_back(name);
    std::string how = "it has the same sensors on the face in another order";
    if (!more.empty() || !fewer.empty())
      how = fmt::format("it has other sensors on the face:{}{}",
                        more.empty() ? "" : fmt::format(" {} too many", fmt::join(more, ", ")),
                        fewer.empty()
                            ? ""
                            : fmt::format("{}{} missing", more.empty() ? " " : ", ", fmt::join(fewer, ", ")));
    found.left_out.push_back({paths[i], std::move(take.performer), ErrorCode::mismatch,
                              excerpt(how, 3 * kComplaintLetters), videos_beside(paths[i])});
  }
  std::ranges::sort(found.left_out, {}, &LeftOutTake::path);
  return found;
}

Result<RecordedDataset> read_dataset(const FoundTakes& found, const Progress& progress,
                                     const TakeVisitor& visitor) {
  RecordedDataset dataset{found.folder, found.sensors, {}, found.left_out, {}, {}};
  WeightHistogram weights;
  for (std::size_t i = 0; i < found.takes.size(); ++i) {
    const FoundTakes::Take& file = found.takes[i];
    if (!progress(static_cast<double>(i) / static_cast<double>(found.takes.size()), "reading takes"))
      return fail(ErrorCode::cancelled, "stopped", found.folder.string());
    const Result<take::Take> take = take::Take::open(file.path);
    Result<RecordedTake> read =
        take ? read_recorded_take(*take) : Result<RecordedTake>(std::unexpected(take.error()));
    if (!read) {
      dataset.left_out.push_back(left_out_by(file.path, file.performer, std::move(read).error()));
      continue;
    }
    if (visitor) MIEN_TRY(visitor(*read));
    weights.add(read->weights);
    dataset.takes.push_back(std::move(read->overview));
  }
  progress(1, "reading takes");
  std::ranges::sort(dataset.left_out, {}, &LeftOutTake::path);
  std::map<std::string, std::vector<std::size_t>> people;
  for (std::size_t i = 0; i < dataset.takes.size(); ++i) people[dataset.takes[i].performer].push_back(i);
  for (auto& [name, takes] : people) dataset.people.push_back({name, std::move(takes)});
  dataset.ranges = weights.ranges();
  return dataset;
}

}  // namespace mien::dataset
