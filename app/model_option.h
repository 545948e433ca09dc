#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "mien/core/error.h"
#include "mien/study/solve.h"
#include "mien/take/take.h"
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
  /// Solves a take with them, showing progress under `title`; says on stderr where the answer stands on few
  /// of the sensors or on none.
  [[nodiscard]] Result<study::Solution> solve(const take::Take& take, const tracker::WindowSolver& solver,
                                              study::SolveFrom from, const std::string& title) const;
};

}  // namespace mien::app
