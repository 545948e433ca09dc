#include "mien/dataset/training_takes.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "mien/core/excerpt.h"
#include "mien/dataset/recorded_dataset.h"
#include "mien/dataset/splits.h"
#include "mien/solve/trace_features.h"

namespace mien::dataset {
namespace {

/// Of one person alone this share of each take validates, its end.
constexpr double kValidatesAlone = 0.2;

/// Stretches of one take.
using TakeStretches = std::vector<CountedStretch>;

/// Divides one take of the only person: its last part validates, what is long enough before it trains.
void divide_take(const TakeStretches& take, std::size_t sensors, TrainingData& data) {
  std::size_t all = 0;
  for (const CountedStretch& stretch : take) all += stretch.sequence.frames;
  // When the frame comes, of those that count, with which validation begins.
  auto left = static_cast<std::size_t>(static_cast<double>(all) * (1 - kValidatesAlone));
  DeviceTime from;
  for (const CountedStretch& stretch : take) {
    from = stretch.begin + frame_offset(static_cast<std::int64_t>(left));
    if (left < stretch.sequence.frames) break;
    left -= stretch.sequence.frames;
  }
  const DeviceTime until = from - from_seconds(kApartS);
  for (const CountedStretch& stretch : take) {
    // How many of its frames are before a time.
    const auto before = [&](DeviceTime time) {
      const double frames = to_seconds(time - stretch.begin) * kFrameRateHz;
      return static_cast<std::size_t>(
          std::clamp(frames + 0.5, 0.0, static_cast<double>(stretch.sequence.frames)));
    };
    const auto add = [&](std::size_t first, std::size_t end, std::uint32_t performer, Dataset& to) {
      if (end < first + kShortestStretchFrames) return;
      to.sequences.push_back(cut_sequence(stretch.sequence, sensors, first, end - first));
      to.sequences.back().performer = performer;
    };
    add(0, before(until), 0, data.train);
    add(before(from), stretch.sequence.frames, 1, data.validation);
  }
}

/// Who validates where nobody says.
Result<Splits> fifth_of(std::vector<std::string> people, std::uint64_t seed) {
  const double fifth = static_cast<double>(people.size() / 5) / static_cast<double>(people.size());
  // One at least, which any share above none is.
  return draw_splits(std::move(people), {.validation = std::max(fifth, 1e-6), .test = 0}, seed);
}

}  // namespace

Result<TakesData> read_training_takes(const std::filesystem::path& folder,
                                      const std::filesystem::path& splits_file, const sensor::Rig& rig,
                                      std::uint64_t seed, const Progress& progress) {
  MIEN_TRY_ASSIGN(const FoundTakes found, find_takes(folder, solve::traced_sensor_names(rig), progress));
  const bool other_sensors = std::ranges::any_of(
      found.left_out, [](const LeftOutTake& take) { return take.code == ErrorCode::mismatch; });
  if (found.takes.empty() && other_sensors)
    return fail(ErrorCode::mismatch,
                fmt::format("no take has the face sensors of the rig {}", excerpt(rig.name)), folder.string(),
                "train with the rig that they were recorded with");
  std::optional<Splits> splits;
  if (!splits_file.empty()) {
    MIEN_TRY_ASSIGN(splits, read_splits(splits_file, found.people()));
  }
  TakesData out;
  std::map<std::string, std::vector<TakeStretches>> people;
  MIEN_TRY_ASSIGN(
      const RecordedDataset dataset, read_dataset(found, progress, [&](RecordedTake& take) -> Result<void> {
        const std::string& person = take.overview.performer;
        if (splits) {
          MIEN_TRY_ASSIGN(const Split split, split_of(*splits, person, splits_file.string()));
          if (split == Split::test) {
            out.left_out.push_back(fmt::format("{}: {} is kept for the test",
                                               take.overview.path.filename().string(), excerpt(person, 60)));
            return {};
          }
        }
        people[person].push_back(std::move(take.stretches));
        return {};
      }));
  for (const LeftOutTake& take : dataset.left_out) out.left_out.push_back(take.sentence());

  std::vector<std::string> names;
  for (const auto& [name, takes] : people) names.push_back(name);
  if (names.empty())
    return fail(ErrorCode::not_found, "no take in it counts", folder.string(),
                out.left_out.empty() ? "record one" : excerpt(out.left_out.front(), 2 * kComplaintLetters));
  out.data.train.sensors = out.data.validation.sensors = found.sensors;
  if (!splits && names.size() == 1) {
    for (const TakeStretches& take : people.begin()->second)
      divide_take(take, found.sensors.size(), out.data);
    out.left_out.push_back(
        fmt::format("{} is alone: the last fifth of each take validates, and the {:.0f} s before it are left "
                    "out; it says nothing of others",
                    excerpt(names.front(), 60), kApartS));
    out.training_people = out.validation_people = names;
  } else {
    if (!splits) {
      MIEN_TRY_ASSIGN(splits, fifth_of(names, seed));
    }
    for (std::size_t p = 0; p < names.size(); ++p) {
      const bool trains = splits->where(names[p]) == Split::train;
      (trains ? out.training_people : out.validation_people).push_back(names[p]);
      for (TakeStretches& take : people[names[p]])
        for (CountedStretch& stretch : take) {
          stretch.sequence.performer = static_cast<std::uint32_t>(p);
          (trains ? out.data.train : out.data.validation).sequences.push_back(std::move(stretch.sequence));
        }
    }
  }
  const std::string where = splits_file.empty() ? folder.string() : splits_file.string();
  if (out.data.train.sequences.empty())
    return fail(ErrorCode::not_found, "nobody with a take that counts is there to train on", where,
                "record more, or put somebody else into train");
  if (out.data.validation.sequences.empty())
    return fail(ErrorCode::not_found, "nobody with a take that counts is there to validate on", where,
                "record more, or put somebody else into validation");
  return out;
}

}  // namespace mien::dataset
