#pragma once

#include "app/command.h"

namespace mien::app {

/// Adds `mien bench start` beneath `bench`.
void add_start_bench(Commands& commands, CLI::App* bench);

}  // namespace mien::app
