#pragma once

#include "app/command.h"

namespace mien::lab {

/// `mien study loss`, beneath `mien study`.
void add_study_loss(app::Commands& commands, app::Command study);

}  // namespace mien::lab
