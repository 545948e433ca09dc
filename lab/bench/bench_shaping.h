#pragma once

#include "app/command.h"

namespace mien::lab {

/// Adds `mien bench shaping` beneath `bench`.
void add_shaping_bench(app::Commands& commands, app::Command bench);

}  // namespace mien::lab
