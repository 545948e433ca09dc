#pragma once

#include "app/command.h"

namespace mien::lab {

/// Adds `mien bench attack` beneath `bench`.
void add_attack_bench(app::Commands& commands, app::Command bench);

}  // namespace mien::lab
