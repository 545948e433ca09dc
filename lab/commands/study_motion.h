#pragma once

#include "app/command.h"

namespace mien::lab {

/// `mien study motion`, beneath `mien study`.
void add_study_motion(app::Commands& commands, app::Command study);

}  // namespace mien::lab
