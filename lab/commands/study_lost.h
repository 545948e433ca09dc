#pragma once

#include "app/command.h"

namespace mien::lab {

/// `mien study lost`, beneath `mien study`.
void add_study_lost(app::Commands& commands, app::Command study);

}  // namespace mien::lab
