#pragma once

#include <cstddef>
#include <string>

#include "mien/core/error.h"
#include "mien/synthetic/imu/make_dataset.h"
#include "mien/train/recipe.h"

namespace mien::train {

/// The share of a step's windows that are to be drawn from takes: the recipe's, kUsualTakesShare where it
/// says none and takes are given, 0 where there are none. `where` names the recipe in messages. Errors:
/// bad_usage (the recipe asks for takes and none are given, or for none of those that are).
[[nodiscard]] Result<double> takes_share(const Recipe& recipe, bool takes_given, const std::string& where);

/// Marks the sequences as takes', and leaves out those that are shorter than `window` frames. Errors:
/// bad_usage (nothing is left to train on).
[[nodiscard]] Result<dataset::TrainingData> as_takes(dataset::TrainingData takes, std::size_t window);

/// Length of all its sequences.
[[nodiscard]] double minutes_of(const dataset::Dataset& dataset);

/// How much of a data set is from takes.
struct TakesAmount {
  std::size_t people = 0;
  double minutes = 0;
};
[[nodiscard]] TakesAmount takes_in(const dataset::Dataset& dataset);

/// What a frame counts for in what is measured of a data set.
struct FrameWeights {
  double performed = 1;  ///< One of a virtual performer's.
  double taken = 1;      ///< One of a take's.
  [[nodiscard]] double of(const dataset::Sequence& sequence) const {
    return sequence.from_take ? taken : performed;
  }
};
/// Those by which takes are `share` of the whole, as they are of the windows that are drawn; 1 where there is
/// one kind alone.
[[nodiscard]] FrameWeights as_drawn(const dataset::Dataset& dataset, double share);

/// Whether window `index` of a step is drawn from takes. Windows of takes are evenly spread, and any one is
/// of a take with the probability `share`. `phase` in [0, 1): drawn anew for each step.
[[nodiscard]] bool is_from_take(std::size_t index, double share, double phase);

}  // namespace mien::train
