#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study ablation`, beneath `mien study`.
void add_study_ablation(Commands& commands, Command study);

}  // namespace mien::app
