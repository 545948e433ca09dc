#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study phone`.
void add_study_phone(Commands& commands, Command study);

}  // namespace mien::app
