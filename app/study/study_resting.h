#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study resting`, beneath `mien study`.
void add_study_resting(Commands& commands, Command study);

}  // namespace mien::app
