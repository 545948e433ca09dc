#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "mien/core/error.h"
#include "mien/tracker/window_solver.h"

namespace mien::app {

/// What the commands that solve takes have in common: which model, and how it is sampled.
struct ModelOption {
  std::string path;  ///< Empty: the default model.
  int steps = 0;     ///< 0: as the model file says.

  void add_to(CLI::App* command);
  /// Reads the model. Errors: not_found (no default model is installed), and the model reader's.
  [[nodiscard]] Result<tracker::WindowSolver> open();
  /// The model's own settings with this command line's.
  [[nodiscard]] model::SamplerSettings settings(const tracker::WindowSolver& solver) const;
};

}  // namespace mien::app
