#pragma once

#include <cstddef>

#include "app/command_line.h"
#include "lab/imu/short_recipe.h"

namespace mien::lab {

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
