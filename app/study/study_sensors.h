#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study sensors`, beneath `mien study`.
void add_study_sensors(Commands& commands, Command study);

}  // namespace mien::app
