#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lab/imu/person_errors.h"
#include "lab/imu/short_recipe.h"
#include "lab/imu/short_training.h"
#include "lab/interval.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/sensor/rig.h"

namespace mien::lab {

/// How sets of sensors are held against each other by what networks make of them.
struct PlacementTrainingRequest {
  std::uint64_t seed = 1;
  std::size_t seeds = 3;    ///< Networks of each set, 1 or more.
  std::size_t steps = 600;  ///< Of each network.
  synthetic::DataRecipe data = short_data(1);
  std::size_t test_people = 24;  ///< Whom nobody trained on, 2 or more.
  double test_seconds = 24;      ///< Of each, in either profile.
  unsigned threads = 0;          ///< 0: one a core.
};

/// A set of sensors as people would wear it, with its [skin].
struct PlacementRig {
  std::string name;  ///< In file names: lower case letters, digits, '-' and '_'.
  std::string title;
  sensor::Rig rig;
};

/// What networks of a set are off on people whom nobody trained on.
struct TrainedPlacement {
  std::string name, title;
  std::size_t sensors = 0;
  SeedErrors device, lab;  ///< In either profile.
};

/// Trains and tries each set. Every set has data of its own, which the same virtual people perform: what a
/// sensor's heading is told by are the other sensors of *its* rig, so that sensors of one set cannot be taken
/// out of the performances of a larger one. Errors: make_dataset's, `train`'s; cancelled.
[[nodiscard]] Result<std::vector<TrainedPlacement>> train_placements(const PlacementTrainingRequest& request,
                                                                     std::span<const PlacementRig> rigs,
                                                                     const TrainShort& train,
                                                                     const Progress& progress);

/// Two sets of as many sensors: which is better, by the vertex error in *device*.
struct PlacementContest {
  std::string ours, paper;  ///< Titles.
  Interval device, lab;     ///< Change of the vertex error from the paper's to ours, as a share.
  Interval device_mse, lab_mse;
  /// A sentence that names the better one with its interval, or says that neither is.
  [[nodiscard]] std::string verdict() const;
};

[[nodiscard]] PlacementContest contest(const TrainedPlacement& ours, const TrainedPlacement& paper);

}  // namespace mien::lab
