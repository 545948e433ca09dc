#include "app/model_option.h"

#include <fmt/format.h>

#include <cstdio>
#include <utility>

#include "app/command.h"
#include "mien/core/files.h"
#include "mien/model/model_file.h"
#include "mien/tracker/causal_tracker.h"

namespace mien::app {

OpenModel::OpenModel(tracker::WindowSolver solver, int steps) : model_(std::move(solver)) {
  settings_ = file().sampler;
  if (steps > 0) {
    settings_.steps = static_cast<std::size_t>(steps);
    settings_.kind =
        settings_.steps == file().schedule.levels ? model::SamplerKind::ddpm : model::SamplerKind::ddim;
  }
}

const model::ModelFile& OpenModel::file() const {
  const auto* solver = std::get_if<tracker::WindowSolver>(&model_);
  return solver != nullptr ? solver->file() : std::get<model::ModelFile>(model_);
}

int OpenModel::steps() const {
  return std::holds_alternative<tracker::WindowSolver>(model_) ? static_cast<int>(settings_.steps) : 0;
}

Result<study::Solution> OpenModel::solve(const take::Take& take, study::SolveFrom from,
                                         const std::string& title) const {
  constexpr double kFew = 0.5;
  study::Solution solution;
  const Progress progress = terminal_progress(title);
  if (const auto* solver = std::get_if<tracker::WindowSolver>(&model_)) {
    MIEN_TRY_ASSIGN(solution, study::solve_take(take, *solver, from, settings_, progress));
  } else {
    MIEN_TRY_ASSIGN(
        tracker::CausalTracker tracker,
        tracker::CausalTracker::create(std::get<model::ModelFile>(model_), take.rig().face_sensor_names()));
    MIEN_TRY_ASSIGN(solution, study::solve_take(take, tracker, from, progress));
  }
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

void ModelOption::add_to(CLI::App* command) {
  CLI::Option* named =
      command->add_option("--model", path, "Model file (default: models/default.safetensors)");
  CLI::Option* counted =
      command
          ->add_option("--steps", steps,
                       "Denoising steps a window; 1000 is the published sampler (default: the model's own)")
          ->check(CLI::Range(1, 1000));
  command->add_flag("--live", live, "The live model, frame by frame, which sees nothing of what comes later")
      ->excludes(named)
      ->excludes(counted);
}

Result<OpenModel> ModelOption::open() {
  if (path.empty()) {
    MIEN_TRY_ASSIGN(path, find_resource(live ? "models/live.safetensors" : "models/default.safetensors"));
  }
  MIEN_TRY_ASSIGN(model::ModelFile file, model::read_model(path));
  if (file.architecture.kind == model::NetworkKind::causal) {
    if (steps > 0)
      return fail(ErrorCode::bad_usage, "a causal model answers at once, without denoising steps", path,
                  "leave --steps out");
    return OpenModel(std::move(file));
  }
  MIEN_TRY_ASSIGN(tracker::WindowSolver solver, tracker::WindowSolver::create(std::move(file)));
  return OpenModel(std::move(solver), steps);
}

}  // namespace mien::app
