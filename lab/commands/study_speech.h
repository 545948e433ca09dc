#pragma once

#include "app/command.h"

namespace mien::lab {

/// `mien study speech`, beneath `mien study`.
void add_study_speech(app::Commands& commands, app::Command study);

}  // namespace mien::lab
