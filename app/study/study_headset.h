#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study headset`, beneath `mien study`.
void add_study_headset(Commands& commands, Command study);

}  // namespace mien::app
