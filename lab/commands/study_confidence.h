#pragma once

#include "app/command.h"

namespace mien::lab {

/// `mien study confidence`, beneath `mien study`.
void add_study_confidence(app::Commands& commands, app::Command study);

}  // namespace mien::lab
