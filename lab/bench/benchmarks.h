#pragma once

#include "app/command.h"

namespace mien::lab {

/// `bench` and its commands.
void add_benchmarks(app::Commands& commands);

}  // namespace mien::lab
