#pragma once

#include "app/command.h"

namespace mien::lab {

/// `mien study hours`.
void add_study_hours(app::Commands& commands, app::Command study);

}  // namespace mien::lab
