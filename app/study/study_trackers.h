#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study trackers`, beneath `mien study`.
void add_study_trackers(Commands& commands, Command study);

}  // namespace mien::app
