#pragma once

#include <string>
#include <vector>

#include "app/child_program.h"
#include "mien/core/error.h"

namespace mien::app {

/// Becomes the helper mien-train with these arguments, so that its exit status, its progress and Ctrl-C are
/// the program's own, and it calls itself mien; comes back only with an error. Errors: not_found (no helper),
/// io.
[[nodiscard]] Result<void> become_trainer(std::vector<std::string> arguments);

/// What mien-train prints when it is given these arguments. Errors: not_found (no helper), io (what it says).
[[nodiscard]] Result<std::string> ask_trainer(std::vector<std::string> arguments);

/// The helper mien-train at work with these arguments. Errors: not_found (no helper), io.
[[nodiscard]] Result<Child> start_trainer(std::vector<std::string> arguments);

}  // namespace mien::app
