#pragma once

#include "app/command.h"

namespace mien::app {

/// Adds `mien bench render` beneath `bench`.
void add_render_bench(Commands& commands, Command bench);

}  // namespace mien::app
