#pragma once

#include <string>
#include <vector>

#include "mien/core/error.h"

namespace mien::app {

/// What another program said until it ended.
struct ChildOutput {
  bool succeeded = false;  ///< Its exit status was 0.
  std::string out;         ///< Standard output, ...
  std::string complaints;  ///< ... and standard error.
};

/// As programs are given their arguments and their environment, with a null behind; valid while `texts` is as
/// it is.
[[nodiscard]] std::vector<char*> pointers(std::vector<std::string>& texts);

/// Runs a program, found along PATH where its name has no slash, without standard input, and waits for it.
/// `command`: name and arguments; `environment`: its whole environment, or empty for this program's own.
/// Errors: not_found (no such program), io.
[[nodiscard]] Result<ChildOutput> run_child(std::vector<std::string> command,
                                            std::vector<std::string> environment = {});

}  // namespace mien::app
