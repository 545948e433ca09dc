#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study live`, beneath `mien study`.
void add_study_live(Commands& commands, CLI::App* study);

}  // namespace mien::app
