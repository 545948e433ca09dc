#pragma once

#include "app/command.h"

namespace mien::lab {

/// `mien study sensors`, beneath `mien study`.
void add_study_sensors(app::Commands& commands, app::Command study);

}  // namespace mien::lab
