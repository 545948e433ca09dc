#pragma once

#include "app/command.h"

namespace mien::lab {

/// Adds `mien bench onnxruntime` beneath `bench`.
void add_onnxruntime_bench(app::Commands& commands, app::Command bench);

}  // namespace mien::lab
