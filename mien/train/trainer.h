#pragma once

#include <filesystem>
#include <string>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/train/recipe.h"
#include "mien/train/task.h"

namespace mien::train {

struct TrainOptions {
  /// The model, written last. While training, OUT.checkpoint stands beside it; the loss curve goes to OUT
  /// with the extension csv, and is whole when the model is there.
  std::filesystem::path out;
  std::filesystem::path from;  ///< Begin with this model's network; empty: with weights drawn anew.
  bool resume = false;         ///< Go on from the checkpoint, if there is one.
  bool force = false;          ///< Replace a model, or drop a checkpoint, whatever it is.
  std::string device = "cpu";  ///< "cpu", "cuda" or "cuda:1".
  int threads = 0;             ///< Of libtorch on the CPU; 0: all cores.
};

struct TrainReport {
  std::filesystem::path model;  ///< Where it was written: `out`, or beside it when a better one stands there.
  bool replaced = true;         ///< False when the one at `out` is better and stays.
  std::string results;          ///< As in the model file: JSON.
};

/// Trains the task's network and writes the model.
/// Every step depends on the recipe, the data and the step's number alone: with a budget in steps, a run that
/// was killed and resumed ends with the same bits, and the same curve but for its seconds, on the same
/// machine and number of threads. A stop by `progress` leaves a checkpoint. Errors: bad_usage, mismatch
/// (data, checkpoint or model of another run), cancelled, io, internal (the loss is no longer finite).
[[nodiscard]] Result<TrainReport> train(Task& task, const TrainOptions& options, const Progress& progress);

/// Training speed on made-up windows, in windows a second, the median over `steps`.
[[nodiscard]] Result<double> measure_speed(const Recipe& recipe, std::size_t sensors, std::size_t steps,
                                           const std::string& device, int threads);

}  // namespace mien::train
