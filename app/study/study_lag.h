#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study lag`, beneath `mien study`.
void add_study_lag(Commands& commands, Command study);

}  // namespace mien::app
