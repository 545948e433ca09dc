#pragma once

#include "app/command.h"

namespace mien::lab {

/// `mien study trackers`, beneath `mien study`.
void add_study_trackers(app::Commands& commands, app::Command study);

}  // namespace mien::lab
