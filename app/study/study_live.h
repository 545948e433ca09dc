#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study live`, beneath `mien study`.
void add_study_live(Commands& commands, Command study);

}  // namespace mien::app
