#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study lost`, beneath `mien study`.
void add_study_lost(Commands& commands, Command study);

}  // namespace mien::app
