#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study hand`, beneath `mien study`.
void add_study_hand(Commands& commands, Command study);

}  // namespace mien::app
