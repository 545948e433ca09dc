#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/core/random.h"
#include "mien/model/safetensors.h"
#include "mien/train/batches.h"
#include "mien/train/recipe.h"

namespace mien::train {

/// What a network learns from, or is validated on.
struct TaskData {
  std::string hash;  ///< Over everything that training, or a score, depends on beside the recipe's text.
  std::size_t frames = 0;
};

/// What a network is to learn: data in batches, and the file that its weights end in. Training itself knows
/// no more of it. Those who perform for validation are not in the training.
class Task {
 public:
  virtual ~Task() = default;

  /// As it was read, with the network's condition and outputs filled in.
  [[nodiscard]] const Recipe& recipe() const { return recipe_; }
  [[nodiscard]] const TaskData& training_data() const { return training_data_; }
  [[nodiscard]] const TaskData& validation_data() const { return validation_data_; }

  /// `count` windows at random places of the training, augmented. Thread-safe.
  [[nodiscard]] virtual Batch random_batch(std::size_t count, Random random) const = 0;
  /// At most recipe().windows of validation, evenly spread, nothing lost.
  [[nodiscard]] virtual Batch validation_batch(Random random) const = 0;
  /// What a validation score is made of, shares that sum to 1: all of validation_batch(), unless a task
  /// measures several kinds of people apart.
  [[nodiscard]] virtual std::vector<ValidationPart> validation_parts(Random random) const {
    return {{.name = "all", .share = 1, .windows = validation_batch(random)}};
  }

  /// The results text of a model of this kind. Errors: the model reader's.
  [[nodiscard]] virtual Result<std::string> results_of(const std::filesystem::path& model) const = 0;
  /// Takes over what stands around the network of a model of this kind (its normalisation), and gives the
  /// network, for training to go on from. To be called before any batch is made. Errors: the model reader's;
  /// mismatch (of another size, or of other sensors).
  [[nodiscard]] virtual Result<std::vector<model::Tensor>> begin_with(const std::filesystem::path& model) = 0;
  /// Measures a trained network, beside what baselines do, and keeps it for write(). Returns a JSON object
  /// that results are completed by. Errors: cancelled, and those of the run time.
  [[nodiscard]] virtual Result<std::string> assess(std::span<const model::Tensor> network,
                                                   const Progress& progress) = 0;
  /// The model that was assessed, whole or not at all. Errors: io.
  [[nodiscard]] virtual Result<void> write(const std::filesystem::path& path,
                                           const std::string& results) const = 0;

 protected:
  Task(Recipe recipe, TaskData training, TaskData validation)
      : recipe_(std::move(recipe)),
        training_data_(std::move(training)),
        validation_data_(std::move(validation)) {}

  Recipe recipe_;

 private:
  TaskData training_data_, validation_data_;
};

/// A task that makes one file of what it learns: `File` has the network with its `architecture`, `recipe` and
/// `results`, and is read and written by these functions.
template <class File, Result<File> (*kRead)(const std::filesystem::path&),
          Result<void> (*kWrite)(const std::filesystem::path&, const File&)>
class FileTask : public Task {
 public:
  [[nodiscard]] Result<std::string> results_of(const std::filesystem::path& model) const override {
    MIEN_TRY_ASSIGN(File standing, kRead(model));
    return std::move(standing.results);
  }
  [[nodiscard]] Result<void> write(const std::filesystem::path& path,
                                   const std::string& results) const override {
    File whole = model_;
    whole.results = results;
    return kWrite(path, whole);
  }

 protected:
  FileTask(Recipe recipe, TaskData training, TaskData validation, File model = {})
      : Task(std::move(recipe), std::move(training), std::move(validation)), model_(std::move(model)) {
    model_.architecture = recipe_.architecture;
    model_.recipe = recipe_.text;
  }

  File model_;
};

}  // namespace mien::train
