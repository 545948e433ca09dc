#pragma once

#include "app/command.h"

namespace mien::lab {

/// Adds `mien bench render` beneath `bench`.
void add_render_bench(app::Commands& commands, app::Command bench);

}  // namespace mien::lab
