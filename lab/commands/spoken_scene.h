#pragma once

#include <string>

#include "app/command.h"
#include "lab/speech/spoken_session.h"

namespace mien::lab {

/// --rig, of a study of people who speak.
void add_spoken_rig_option(app::Command command, std::string& rig);

/// The rig of that option with its live model, and the network that hears. Errors: the readers'.
[[nodiscard]] Result<SpokenScene> read_spoken_scene(const std::string& rig);

}  // namespace mien::lab
