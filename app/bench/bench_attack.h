#pragma once

#include "app/command.h"

namespace mien::app {

/// Adds `mien bench attack` beneath `bench`.
void add_attack_bench(Commands& commands, Command bench);

}  // namespace mien::app
