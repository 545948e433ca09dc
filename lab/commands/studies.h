#pragma once

#include "app/command.h"

namespace mien::lab {

/// `study` and its commands.
void add_studies(app::Commands& commands);

/// Each adds its command beneath `study`.
void add_study_ablation(app::Commands& commands, app::Command study);
void add_study_confidence(app::Commands& commands, app::Command study);
void add_study_headset(app::Commands& commands, app::Command study);
void add_study_hours(app::Commands& commands, app::Command study);
void add_study_live(app::Commands& commands, app::Command study);
void add_study_loss(app::Commands& commands, app::Command study);
void add_study_motion(app::Commands& commands, app::Command study);
void add_study_placement(app::Commands& commands, app::Command study);
void add_study_sensors(app::Commands& commands, app::Command study);
void add_study_speech(app::Commands& commands, app::Command study);
void add_study_trackers(app::Commands& commands, app::Command study);

}  // namespace mien::lab
