#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/dataset/dataset.h"
#include "mien/sensor/rig.h"

namespace mien::dataset {

/// What people's takes give to train on: frames whose truth counts, each person in one set only.
struct TakesData {
  /// A sequence a stretch of two seconds or more; performers are numbered by name, from 0. No slopes.
  TrainingData data;
  std::vector<std::string> left_out;  ///< Takes and parts of takes, a sentence each.
  /// By name. One person alone is in both.
  std::vector<std::string> training_people, validation_people;
};

/// Between what trains and what validates of one person's take so much is left out, s.
inline constexpr double kApartS = 2;

/// `splits`: a file (read_splits), or empty: every fifth person validates (at least one where there are two),
/// by a draw from `seed`; with one person alone the last fifth of each take's frames that count validates, as
/// a performer of another number, kApartS apart from what trains, and `left_out` says so. Who is kept for the
/// test is left out. `rig`: whose face sensors are trained. Errors: find_takes's and read_splits's; not_found
/// (nothing that counts, to train or to validate on), mismatch (the rig's sensors are none of the takes',
/// somebody is in no set); cancelled. Memory: an hour of eleven sensors is 120 MB.
[[nodiscard]] Result<TakesData> read_training_takes(const std::filesystem::path& folder,
                                                    const std::filesystem::path& splits,
                                                    const sensor::Rig& rig, std::uint64_t seed,
                                                    const Progress& progress);

}  // namespace mien::dataset
