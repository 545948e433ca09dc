#pragma once

#include "app/command.h"

namespace mien::app {

/// Adds `mien face profiles` beneath `mien face`.
void add_face_profiles_command(Commands& commands, Command face);

}  // namespace mien::app
