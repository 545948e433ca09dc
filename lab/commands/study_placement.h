#pragma once

#include "app/command.h"

namespace mien::lab {

/// `mien study placement`, beneath `mien study`.
void add_study_placement(app::Commands& commands, app::Command study);

}  // namespace mien::lab
