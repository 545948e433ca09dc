#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study merged`, beneath `mien study`.
void add_study_merged(Commands& commands, Command study);

}  // namespace mien::app
