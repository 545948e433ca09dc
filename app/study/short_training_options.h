#pragma once

#include <cstddef>

#include "app/command_line.h"
#include "mien/study/imu/short_recipe.h"

namespace mien::app {

/// How much a study by short trainings does, before --quick makes less of it.
struct ShortTrainingAmounts {
  std::size_t& seeds;
  std::size_t& steps;
  study::DataRecipe& data;
  std::size_t& test_people;
  int fewest_people = 1;  ///< That an interval needs.
};

/// --seeds, --steps, --performers and --people.
void add_short_training_options(Command command, const ShortTrainingAmounts& amounts);

}  // namespace mien::app
