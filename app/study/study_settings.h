#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study settings`, beneath `mien study`.
void add_study_settings(Commands& commands, Command study);

}  // namespace mien::app
