#include "lab/commands/short_training_options.h"

namespace mien::lab {

void add_short_training_options(app::Command command, const ShortTrainingAmounts& amounts) {
  command
      .add_option("--seeds", amounts.seeds,
                  "Trainings of each row: more narrow the intervals, and take as much longer")
      .in_range(1, 100)
      .show_default();
  command.add_option("--steps", amounts.steps, "Steps of each training, the same for all rows")
      .in_range(1, 1000000)
      .show_default();
  command.add_option("--performers", amounts.data.performers, "Virtual people who are trained on")
      .in_range(10, 1000000)
      .show_default();
  command.add_option("--people", amounts.test_people, "Virtual people of each kind whom rows are tried on")
      .in_range(amounts.fewest_people, 10000)
      .show_default();
}

}  // namespace mien::lab
