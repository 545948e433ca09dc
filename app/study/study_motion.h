#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study motion`, beneath `mien study`.
void add_study_motion(Commands& commands, Command study);

}  // namespace mien::app
