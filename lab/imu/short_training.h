#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/model/model_file.h"
#include "mien/synthetic/imu/make_dataset.h"

namespace mien::lab {

/// A network that a study trains for itself, with a small budget: short enough that a table of them is a
/// matter of an hour, long enough that rows can be told apart.
struct ShortTraining {
  std::string name;    ///< In progress and file names: lower case letters, digits, '-' and '_'.
  std::string recipe;  ///< As TOML (docs/guide/training.md), with its budget in steps.
  std::string rig;     ///< Text of the rig file, which goes into the model.
  /// Names all that `data` depends on: two trainings with one key have the same data.
  std::string data_key;
  /// Asked for when the training is due, and not at all where its model stands already. Not called from two
  /// threads at once.
  std::function<Result<dataset::TrainingData>(const Progress& progress)> data;
};

/// What came of it.
struct ShortTrained {
  model::ModelFile model;
  /// The loss curve as CSV, a row a validation: step, seconds, windows, learning_rate, training_loss,
  /// validation_loss, validation_mse.
  std::string curve;
};

/// Trains them, or finds them trained: one each, in their order. The same trainings give the same bits,
/// however often it was stopped in between. Given by the program, whose helper knows libtorch. Errors: the
/// data's and the trainer's; cancelled.
using TrainShort = std::function<Result<std::vector<ShortTrained>>(std::span<const ShortTraining> trainings,
                                                                   const Progress& progress)>;

}  // namespace mien::lab
