#include "lab/commands/studies.h"

#include "app/command.h"

namespace mien::lab {

void add_studies(app::Commands& commands) {
  const app::Command study = commands.add("study", "The experiments behind the numbers",
                                          "mien study placement --no-training --out placement", nullptr);
  study.require_commands(0, 1);
  add_study_ablation(commands, study);
  add_study_confidence(commands, study);
  add_study_hours(commands, study);
  app::add_skin_command(commands, study);
  add_study_headset(commands, study);
  add_study_live(commands, study);
  add_study_loss(commands, study);
  add_study_motion(commands, study);
  add_study_placement(commands, study);
  add_study_sensors(commands, study);
  add_study_speech(commands, study);
  add_study_trackers(commands, study);
}

}  // namespace mien::lab
