#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study loss`, beneath `mien study`.
void add_study_loss(Commands& commands, Command study);

}  // namespace mien::app
