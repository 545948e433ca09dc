#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study placement`, beneath `mien study`.
void add_study_placement(Commands& commands, Command study);

}  // namespace mien::app
