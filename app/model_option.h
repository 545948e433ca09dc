#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "app/command_line.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/sensor/rig.h"
#include "mien/shaping/settings.h"
#include "mien/solve/solve.h"
#include "mien/take/take.h"
#include "mien/tracker/window_solver.h"

namespace mien::app {

/// A model that was found, of any kind, and how it is asked.
class OpenModel {
 public:
  /// `steps`: a window network's denoising steps; 0: as its file says.
  OpenModel(tracker::WindowSolver solver, int steps);
  /// `adapt`: it is personalised on each take that has the prompts for it.
  OpenModel(std::filesystem::path path, model::ModelFile causal, bool adapt)
      : model_(std::move(causal)), path_(std::move(path)), adapt_(adapt) {}
  /// Of sensors whose tracker alone reads it, and multiplies with these kernels.
  OpenModel(std::filesystem::path tracked, std::string kernels)
      : path_(std::move(tracked)), kernels_(std::move(kernels)) {}

  /// The training set's; the neutral face where the file keeps none.
  [[nodiscard]] face::BlendshapeWeights mean_pose() const;
  /// Files of the recorded performances that it was trained on (a recipe's data.recorded).
  [[nodiscard]] std::vector<std::string> recorded() const;
  /// Denoising steps; 0 for a causal network, which takes none.
  [[nodiscard]] int steps() const;
  /// What its network multiplies with on this CPU (model::kernel_name()).
  [[nodiscard]] std::string kernels() const;
  using Shaping = std::optional<shaping::ShaperSettings>;
  /// Solves a take, showing progress under `title`: by a live model as a session does (solve::replay_take()).
  /// `shaping`: that of the session; none: its default settings, and a window model's own answer. Says on
  /// stderr where the answer stands on few of the sensors or on none.
  [[nodiscard]] Result<solve::Solution> solve(const take::Take& take, const std::string& title,
                                              const Shaping& shaping = {}) const;
  /// The same by each of these settings.
  [[nodiscard]] Result<std::vector<solve::Solution>> solve_by_each(const take::Take& take,
                                                                   const std::string& title,
                                                                   std::span<const Shaping> shaping) const;

 private:
  [[nodiscard]] const model::ModelFile* file() const;

  /// A causal network's tracker belongs to one take's rig, so it is made when there is one.
  std::variant<std::monostate, tracker::WindowSolver, model::ModelFile> model_;
  std::filesystem::path path_;  ///< Of a model that goes frame by frame.
  std::string kernels_;         ///< Of that; else the model's kind tells.
  model::SamplerSettings settings_;
  bool adapt_ = false;
};

/// What the commands that solve takes have in common: which model, and how it is sampled.
struct ModelOption {
  std::string path;     ///< Empty: the one that a live session of the rig would use.
  bool window = false;  ///< The window model instead, which sees what comes later.
  int steps = 0;        ///< 0: as the model file says.
  /// Where a take has a full prologue and the model can be personalised, that is done first.
  bool adapt = false;

  void add_to(Command command);
  /// Finds the model for takes of a rig; `path` becomes the one that it is. Errors:
  /// not_found (no default model is installed), bad_usage (steps for a model that takes none, a window model
  /// for sensors that have none, or another kind of model where it is asked for), and the model reader's.
  [[nodiscard]] Result<OpenModel> open(const sensor::Rig& rig);
};

/// The settings of shaping that a command which solves takes is given.
struct ShapingOption {
  std::string path;  ///< Empty: none.

  void add_to(Command command);
  /// None where no file is named. Errors: not_found, and parse_settings'.
  [[nodiscard]] Result<std::optional<shaping::ShaperSettings>> read() const;
};

}  // namespace mien::app
