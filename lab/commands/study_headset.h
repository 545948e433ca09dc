#pragma once

#include "app/command.h"

namespace mien::lab {

/// `mien study headset`, beneath `mien study`.
void add_study_headset(app::Commands& commands, app::Command study);

}  // namespace mien::lab
