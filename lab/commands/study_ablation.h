#pragma once

#include "app/command.h"

namespace mien::lab {

/// `mien study ablation`, beneath `mien study`.
void add_study_ablation(app::Commands& commands, app::Command study);

}  // namespace mien::lab
