#pragma once

#include "app/command.h"

namespace mien::app {

/// Adds `mien bench shaping` beneath `bench`.
void add_shaping_bench(Commands& commands, Command bench);

}  // namespace mien::app
