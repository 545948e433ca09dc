#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/dataset/recorded_take.h"

namespace mien::dataset {

/// A dataset has at most so many takes.
inline constexpr std::size_t kMostTakes = 10'000;

/// A take that is left out of a dataset.
struct LeftOutTake {
  std::filesystem::path path;
  std::string performer;  ///< Empty where nobody is known.
  ErrorCode code = ErrorCode::internal;
  std::string why;                     ///< A phrase without a full stop.
  std::vector<TakeVideo> videos = {};  ///< Beside it.

  /// "b.mien: nobody consented to being in a dataset".
  [[nodiscard]] std::string sentence() const;
};

/// The takes of a folder, as far as they are known without computing anything.
struct FoundTakes {
  struct Take {
    std::filesystem::path path;
    std::string performer;
  };
  std::filesystem::path folder;
  std::vector<std::string> sensors;   ///< On the face of every take, in the order of features.
  std::vector<Take> takes;            ///< By their files' names.
  std::vector<LeftOutTake> left_out;  ///< Likewise.

  /// Who recorded one of them, also where it is left out; sorted, each once.
  [[nodiscard]] std::vector<std::string> people() const;
};

/// Looks for takes (*.mien, those in folders within are not looked at) and who recorded them. `sensors`:
/// those that a take must have on the face; empty: those that most have, of equally many the ones of the take
/// that is first by name. Takes that do not open, that nobody consented to, or with other sensors are left
/// out. Errors: not_found (no folder, no take in it), out_of_range (more than kMostTakes), io; cancelled.
[[nodiscard]] Result<FoundTakes> find_takes(const std::filesystem::path& folder,
                                            std::vector<std::string> sensors, const Progress& progress);

/// Somebody who is in a dataset.
struct RecordedPerson {
  std::string name;
  std::vector<std::size_t> takes;  ///< Places in RecordedDataset::takes; at least one.
};

/// A dataset at a glance.
struct RecordedDataset {
  std::filesystem::path folder;
  std::vector<std::string> sensors;                    ///< On the face, in the order of features.
  std::vector<TakeOverview> takes;                     ///< That count, by their files' names.
  std::vector<LeftOutTake> left_out;                   ///< Likewise.
  std::vector<RecordedPerson> people;                  ///< Of the takes that count, by name.
  std::array<ShapeRange, face::kShapeCount> ranges{};  ///< Over all frames that count.

  [[nodiscard]] TakeTotals totals() const;  ///< Of the takes that count.
};

/// What is done with a take that counts, while it is in memory: its stretches and lines may be moved away.
/// Errors end the reading.
using TakeVisitor = std::function<Result<void>(RecordedTake& take)>;

/// Reads one take after the other; one take at a time is in memory. Those that give nothing are left out.
/// Errors: the visitor's; cancelled. Cost: read_recorded_take's of each.
[[nodiscard]] Result<RecordedDataset> read_dataset(const FoundTakes& found, const Progress& progress,
                                                   const TakeVisitor& visitor = {});

}  // namespace mien::dataset
