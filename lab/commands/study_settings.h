#pragma once

#include "app/command.h"

namespace mien::lab {

/// `mien study settings`, beneath `mien study`.
void add_study_settings(app::Commands& commands, app::Command study);

}  // namespace mien::lab
