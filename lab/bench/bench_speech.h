#pragma once

#include "app/command.h"

namespace mien::lab {

/// Adds `mien bench speech` beneath `bench`.
void add_speech_bench(app::Commands& commands, app::Command bench);

}  // namespace mien::lab
