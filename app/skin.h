#pragma once

#include "app/command.h"

namespace mien::app {

/// `mien study skin`, which writes a rig's [skin] table: a tool for rigs, and no study.
void add_skin_command(Commands& commands, const Command& study);

}  // namespace mien::app
