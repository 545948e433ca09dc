#include "app/model_option.h"

#include <fmt/format.h>

#include <cstdio>

#include "app/command.h"
#include "mien/core/files.h"
#include "mien/model/model_file.h"

namespace mien::app {

void ModelOption::add_to(CLI::App* command) {
  command->add_option("--model", path, "Model file (default: models/default.safetensors)");
  command
      ->add_option("--steps", steps,
                   "Denoising steps a window; 1000 is the published sampler (default: the model's own)")
      ->check(CLI::Range(1, 1000));
}

Result<tracker::WindowSolver> ModelOption::open() {
  if (path.empty()) {
    MIEN_TRY_ASSIGN(path, find_resource("models/default.safetensors"));
  }
  MIEN_TRY_ASSIGN(model::ModelFile file, model::read_model(path));
  return tracker::WindowSolver::create(std::move(file));
}

model::SamplerSettings ModelOption::settings(const tracker::WindowSolver& solver) const {
  model::SamplerSettings settings = solver.file().sampler;
  if (steps > 0) {
    settings.steps = static_cast<std::size_t>(steps);
    settings.kind =
        settings.steps == solver.file().schedule.levels ? model::SamplerKind::ddpm : model::SamplerKind::ddim;
  }
  return settings;
}

Result<study::Solution> ModelOption::solve(const take::Take& take, const tracker::WindowSolver& solver,
                                           study::SolveFrom from, const std::string& title) const {
  constexpr double kFew = 0.5;
  MIEN_TRY_ASSIGN(study::Solution solution,
                  study::solve_take(take, solver, from, settings(solver), terminal_progress(title)));
  if (solution.felt == 0)
    fmt::print(
        stderr,
        "mien: {}: no sensor could be used, so the answer is a guess; a take needs a prologue (neutral, nod, "
        "shake) to be calibrated by\n",
        take.path().string());
  else if (solution.felt < kFew)
    fmt::print(stderr, "mien: {}: only {:.0f} % of the sensors' readings could be used\n",
               take.path().string(), 100 * solution.felt);
  return solution;
}

}  // namespace mien::app
