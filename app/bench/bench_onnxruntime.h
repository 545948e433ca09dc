#pragma once

#include "app/command.h"

namespace mien::app {

/// Adds `mien bench onnxruntime` beneath `bench`.
void add_onnxruntime_bench(Commands& commands, Command bench);

}  // namespace mien::app
