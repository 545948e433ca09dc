#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study hours`.
void add_study_hours(Commands& commands, Command study);

}  // namespace mien::app
