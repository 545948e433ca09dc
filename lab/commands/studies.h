#pragma once

#include "app/command.h"

namespace mien::lab {

/// `study` and its commands.
void add_studies(app::Commands& commands);

}  // namespace mien::lab
