#pragma once

#include "app/command.h"

namespace mien::lab {

/// `mien study live`, beneath `mien study`.
void add_study_live(app::Commands& commands, app::Command study);

}  // namespace mien::lab
