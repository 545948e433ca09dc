#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace mien::app {

/// What is wrong with a command line that `program` refused with `error`, as one line without the program's
/// name: which command, what is wrong, what to do ("live: there is no option --recrod; did you mean
/// --record? see mien live --help").
[[nodiscard]] std::string usage_error(const CLI::App& program, const CLI::ParseError& error);

}  // namespace mien::app
