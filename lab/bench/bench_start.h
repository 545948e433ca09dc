#pragma once

#include "app/command.h"

namespace mien::lab {

/// Adds `mien bench start` beneath `bench`.
void add_start_bench(app::Commands& commands, app::Command bench);

}  // namespace mien::lab
