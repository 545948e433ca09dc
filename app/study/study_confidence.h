#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study confidence`, beneath `mien study`.
void add_study_confidence(Commands& commands, Command study);

}  // namespace mien::app
