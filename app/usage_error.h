#pragma once

#include <string>

#include "app/command_line.h"

namespace mien::app {

/// What is wrong with a command line that `program` refused with `error`, as one line without the program's
/// name: which command, what is wrong, what to do ("live: there is no option --recrod; did you mean
/// --record? see mien live --help").
[[nodiscard]] std::string usage_error(const Command& program, const ParseError& error);

}  // namespace mien::app
