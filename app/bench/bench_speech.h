#pragma once

#include "app/command.h"

namespace mien::app {

/// Adds `mien bench speech` beneath `bench`.
void add_speech_bench(Commands& commands, Command bench);

}  // namespace mien::app
