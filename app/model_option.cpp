#include "app/model_option.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <utility>

#include "app/command.h"
#include "mien/modalities/modalities.h"
#include "mien/model/linear.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig_part.h"
#include "mien/solve/prompted.h"
#include "mien/tracker/causal_tracker.h"

namespace mien::app {
namespace {

/// A wearer's model, and what it took to learn; or why it is the standard one.
struct Adapted {
  std::optional<tracker::Personalisation> personalised;
  double seconds = 0;
  std::string unlearnt;
};
Result<Adapted> adapt(const take::Take& take, std::span<const model::FeatureFrame> features,
                      model::ModelFile& file) {
  MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
  MIEN_TRY_ASSIGN(const std::optional<DeviceTime> until, solve::first_evaluated(take));
  Adapted out;
  // What is measured is not learnt from.
  const std::vector<tracker::PromptedExpression> prompts = solve::prompted_expressions(events);
  const auto before =
      std::ranges::count_if(prompts, [&](const auto& prompt) { return !until || prompt.end <= *until; });
  if (before < static_cast<std::ptrdiff_t>(tracker::kLeastPrompts)) {
    // Who prompted nothing expects nothing.
    if (!prompts.empty())
      out.unlearnt = fmt::format(
          "{} of its {} prompted expressions come before what is measured, and it takes {}; "
          "begin a take with a full prologue (mien perform --prologue full), or say --no-adapt",
          before, prompts.size(), tracker::kLeastPrompts);
    return out;
  }
  const auto start = std::chrono::steady_clock::now();
  auto learnt = solve::personalise_on(take, features, file, until);
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!learnt && learnt.error().code != ErrorCode::not_found) return std::unexpected(learnt.error());
  if (!learnt) {
    out.unlearnt = fmt::format("{}; {}", learnt.error().what, learnt.error().fix);
    return out;
  }
  out.personalised = *learnt;
  if (!learnt->taken)
    out.unlearnt = fmt::format(
        "what was learnt foretells prompts that were held out no better than the standard skin does "
        "(surprise {:.3f}, without it {:.3f}); check the sensors and record the prompts again",
        learnt->surprise_after, learnt->surprise_before);
  return out;
}

/// Says on stderr where a solution is based on few of the sensors or on none.
void warn_of_missing_sensors(const take::Take& take, const solve::Solution& solution) {
  constexpr double kFew = 0.5;
  if (solution.observed >= kFew) return;
  const std::string few =
      solution.observed > 0
          ? fmt::format("only {:.0f} % of the sensors' readings could be used", 100 * solution.observed)
          : "no sensor could be used, so the answer is a guess";
  const char* const remedy =
      solution.uncalibrated
          ? "a take needs a prologue (a neutral face, and a nod and a shake where the sensors ask for them) "
            "to be calibrated by"
          : "mien take info says what each of them sent";
  fmt::print(stderr, "mien: {}: {}; {}\n", take.path().string(), few, remedy);
}

}  // namespace

OpenModel::OpenModel(tracker::WindowSolver solver, int steps) : model_(std::move(solver)) {
  settings_ =
      solve::sampler_of(std::get<tracker::WindowSolver>(model_).file(), static_cast<std::size_t>(steps));
}

face::BlendshapeWeights OpenModel::mean_pose() const {
  face::BlendshapeWeights pose;
  if (const auto* solver = std::get_if<tracker::WindowSolver>(&model_))
    std::ranges::copy(solver->file().mean_pose, pose.values.begin());
  else if (const auto* causal = std::get_if<model::ModelFile>(&model_))
    std::ranges::copy(causal->mean_pose, pose.values.begin());
  return pose;
}

int OpenModel::steps() const {
  return std::holds_alternative<tracker::WindowSolver>(model_) ? static_cast<int>(settings_.steps) : 0;
}

std::string OpenModel::kernels() const {
  if (!kernels_.empty()) return kernels_;
  return model::kernel_name(std::holds_alternative<model::ModelFile>(model_) ? tracker::kLivePrecision
                                                                             : model::Precision::fp32);
}

Result<solve::Solution> OpenModel::solve(const take::Take& take, const std::string& title,
                                         const Shaping& shaping) const {
  solve::Solution solution;
  const Progress progress = terminal_progress(title);
  if (const auto* solver = std::get_if<tracker::WindowSolver>(&model_)) {
    MIEN_TRY_ASSIGN(solution, solve::solve_take(take, *solver, settings_, progress));
  } else if (const auto* causal = std::get_if<model::ModelFile>(&model_)) {
    MIEN_TRY_ASSIGN(solution, solve_causal(take, *causal, progress, shaping));
  } else {
    MIEN_TRY_ASSIGN(solution, solve_tracked(take, progress, shaping));
  }
  if (shaping && !solution.shaped) solve::shape(*shaping, solution);
  warn_of_missing_sensors(take, solution);
  return solution;
}

Result<std::vector<solve::Solution>> OpenModel::solve_by_each(
    const take::Take& take, const std::string& title,
    std::span<const shaping::ShaperSettings> shaping) const {
  const bool merged = sensor::kinds_of(take.rig()).size() > 1;
  solve::Solution raw;
  if (!merged) {
    MIEN_TRY_ASSIGN(raw, solve(take, title));
  }
  std::vector<solve::Solution> out;
  for (const shaping::ShaperSettings& settings : shaping) {
    if (!merged && !raw.shaped) {
      solve::shape(settings, out.emplace_back(raw));
      continue;
    }
    if (raw.shaped && settings == shaping::ShaperSettings{}) {  // Which is how it was replayed.
      out.push_back(raw);
      continue;
    }
    MIEN_TRY_ASSIGN(
        out.emplace_back(),
        solve(take, fmt::format("{}, {} of {}", title, out.size() + 1, shaping.size()), settings));
  }
  return out;
}

Result<solve::Solution> OpenModel::solve_causal(const take::Take& take, model::ModelFile file,
                                                const Progress& progress, const Shaping& shaping) const {
  const bool live = solve::recorded_live(take);
  std::vector<model::FeatureFrame> features;
  if (!live || adapt_) {
    MIEN_TRY_ASSIGN(features, solve::take_features(take));
  }
  Adapted adapted;
  // Prompts would drop what a phone taught.
  if (adapt_ && file.skin && file.skin->wearer.empty() && !file.correction) {
    progress(0, "learning the wearer");
    MIEN_TRY_ASSIGN(adapted, adapt(take, features, file));
  }
  if (live && !adapted.personalised) {
    MIEN_TRY_ASSIGN(solve::Solution replayed, solve_tracked(take, progress, shaping));
    replayed.unlearnt = std::move(adapted.unlearnt);
    return replayed;
  }
  MIEN_TRY_ASSIGN(tracker::CausalTracker tracker,
                  tracker::CausalTracker::create(std::move(file), take.rig().face_sensor_names()));
  MIEN_TRY_ASSIGN(solve::Solution solution, solve::solve_take(take, features, tracker, progress));
  solution.personalised = adapted.personalised;
  solution.personalise_s = adapted.seconds;
  solution.unlearnt = std::move(adapted.unlearnt);
  return solution;
}

Result<solve::Solution> OpenModel::solve_tracked(const take::Take& take, const Progress& progress,
                                                 const Shaping& shaping) const {
  const shaping::ShaperSettings settings = shaping.value_or(shaping::ShaperSettings{});
  if (solve::recorded_live(take)) return solve::replay_take(take, path_, progress, settings);
  MIEN_TRY_ASSIGN(const std::unique_ptr<tracker::Tracker> tracker,
                  modalities::make_tracker(take.rig(), path_, settings));
  return solve::solve_take(take, *tracker, progress);
}

void ModelOption::add_to(Command command) {
  command.add_option(
      "--model", path,
      "Model file, of any kind (default: the one that a live session of the take's sensors uses, "
      "which goes frame by frame)");
  command
      .add_option("--steps", steps,
                  "Denoising steps a window of a window model; 1000 is the published sampler (default: the "
                  "model's own)")
      .in_range(1, 1000);
  command.add_flag(
      "--window", window,
      "The window model, models/default.safetensors: two seconds at a time, which sees what comes "
      "later, as no session can");
}

Result<OpenModel> ModelOption::open(const sensor::Rig& rig) {
  if (!modalities::has_window_models(rig)) {
    MIEN_TRY_ASSIGN(std::filesystem::path file, modalities::live_model(rig, path));
    path = file.string();
    if (steps > 0)
      return fail(ErrorCode::bad_usage,
                  "this rig's sensors are solved frame by frame, without denoising steps", path,
                  "leave --steps out");
    if (window)
      return fail(ErrorCode::bad_usage, "there is no window model of this rig's sensors", path,
                  "leave --window out");
    return OpenModel(std::move(file), modalities::live_kernels(rig));
  }
  if (window) {
    MIEN_TRY_ASSIGN(path, path_or(path, "models/default.safetensors"));
  } else {
    MIEN_TRY_ASSIGN(path, modalities::live_model(rig, path));
  }
  MIEN_TRY_ASSIGN(model::ModelFile file, model::read_model(path));
  if (file.architecture.kind == model::NetworkKind::causal) {
    if (steps > 0)
      return fail(ErrorCode::bad_usage, "a causal model answers at once, without denoising steps", path,
                  "leave --steps out, or ask the window model with --window");
    if (window)
      return fail(ErrorCode::bad_usage, "this is a live model, which goes frame by frame", path,
                  "leave --window out, or name a window model");
    return OpenModel(path, std::move(file), adapt);
  }
  auto solver = tracker::WindowSolver::create(std::move(file));
  if (!solver) {
    solver.error().where = path;
    return std::unexpected(std::move(solver).error());
  }
  return OpenModel(*std::move(solver), steps);
}

}  // namespace mien::app
