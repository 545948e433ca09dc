#pragma once

#include <cstddef>
#include <filesystem>

#include "app/command_line.h"
#include "lab/imu/short_training.h"

namespace mien::lab {

/// Trains by the helper mien-train, as many at once as there are cores, each with one thread. In `folder`,
/// which is made where it is not and held until what is returned goes, models stand under the training's name
/// and a key of all that it depends on: one that stands there is not trained again, one that was stopped goes
/// on from its checkpoint. Files of data lie there while somebody learns from them; each trainer takes about
/// a gigabyte. However it ends, no trainer works on behind it. Errors: not_found (no helper), mismatch (the
/// folder's models are of another build of the trainer, or of an unknown one), io (another study works there;
/// the folder); of what it returns: io (a full disk; what the trainer says), cancelled.
[[nodiscard]] Result<TrainShort> train_by_helper(const std::filesystem::path& folder);

/// How much a study by short trainings does, before --quick makes less of it.
struct ShortTrainingAmounts {
  std::size_t& seeds;
  std::size_t& steps;
  synthetic::DataRecipe& data;
  std::size_t& test_people;
  int fewest_people = 1;  ///< That an interval needs.
};

/// --seeds, --steps, --performers and --people.
void add_short_training_options(app::Command command, const ShortTrainingAmounts& amounts);

}  // namespace mien::lab
