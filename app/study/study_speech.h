#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study speech`, beneath `mien study`.
void add_study_speech(Commands& commands, Command study);

}  // namespace mien::app
