#pragma once

#include "app/command.h"

namespace mien::app {

/// Adds `mien bench start` beneath `bench`.
void add_start_bench(Commands& commands, Command bench);

}  // namespace mien::app
