#include "app/model_option.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/command.h"
#include "mien/core/files.h"
#include "mien/modalities/modalities.h"
#include "mien/model/linear.h"
#include "mien/model/model_file.h"
#include "mien/solve/prompted.h"
#include "mien/solve/trace_features.h"
#include "mien/tracker/causal_tracker.h"

namespace mien::app {
namespace {

/// A wearer's model, and what it took to learn; or why it is the standard one.
struct Adapted {
  std::optional<tracker::Personalisation> personalised;
  double seconds = 0;
  std::string unlearnt;
};

/// Learns the take's wearer for the model, where the take has the prompts for it. Errors: the take's.
Result<Adapted> adapt(const take::Take& take, model::ModelFile& file) {
  Adapted out;
  // Prompts would drop what a phone taught.
  if (!file.skin || !file.skin->wearer.empty() || file.correction) return out;
  MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
  MIEN_TRY_ASSIGN(const std::optional<DeviceTime> until, solve::first_evaluated(take));
  // What is measured is not learnt from.
  const std::vector<tracker::PromptedExpression> prompts = solve::prompted_expressions(events);
  const auto before =
      std::ranges::count_if(prompts, [&](const auto& prompt) { return !until || prompt.end <= *until; });
  if (before < static_cast<std::ptrdiff_t>(tracker::kLeastPrompts)) {
    // Who prompted nothing expects nothing.
    if (!prompts.empty())
      out.unlearnt = fmt::format(
          "{} of its {} prompted expressions come before what is measured, and it takes {}; begin a take "
          "with a full prologue (mien perform --prologue full), or say --no-adapt",
          before, prompts.size(), tracker::kLeastPrompts);
    return out;
  }
  MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> features, solve::take_features(take));
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
  const char* const remedy = solution.uncalibrated
                                 ? "a take needs a prologue (a neutral face, and a nod and a shake where the "
                                   "sensors ask for them) to be calibrated by"
                                 : "mien take info says what each of them sent";
  fmt::print(stderr, "mien: {}: {}; {}\n", take.path().string(), few, remedy);
}

}  // namespace

OpenModel::OpenModel(tracker::WindowSolver solver, int steps) : model_(std::move(solver)) {
  settings_ =
      solve::sampler_of(std::get<tracker::WindowSolver>(model_).file(), static_cast<std::size_t>(steps));
}

const model::ModelFile* OpenModel::file() const {
  const auto* const solver = std::get_if<tracker::WindowSolver>(&model_);
  return solver != nullptr ? &solver->file() : std::get_if<model::ModelFile>(&model_);
}

face::BlendshapeWeights OpenModel::mean_pose() const {
  face::BlendshapeWeights pose;
  if (file() != nullptr) std::ranges::copy(file()->mean_pose, pose.values.begin());
  return pose;
}

std::vector<std::string> OpenModel::recorded() const {
  try {
    if (file() != nullptr)
      return nlohmann::json::parse(file()->results)
          .at("training")
          .at("recorded")
          .get<std::vector<std::string>>();
  } catch (const nlohmann::json::exception&) {  // It was trained on none.
  }
  return {};
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
  MIEN_TRY_ASSIGN(std::vector<solve::Solution> solved, solve_by_each(take, title, {&shaping, 1}));
  return std::move(solved.front());
}

Result<std::vector<solve::Solution>> OpenModel::solve_by_each(const take::Take& take,
                                                              const std::string& title,
                                                              std::span<const Shaping> shaping) const {
  std::vector<solve::Solution> out;
  if (const auto* solver = std::get_if<tracker::WindowSolver>(&model_)) {
    MIEN_TRY_ASSIGN(const solve::Solution raw,
                    solve::solve_take(take, *solver, settings_, terminal_progress(title)));
    for (const Shaping& settings : shaping) {
      out.push_back(raw);
      if (settings) solve::shape(*settings, out.back());
    }
  } else {
    modalities::LiveModel model(path_);
    Adapted adapted;
    if (const auto* causal = std::get_if<model::ModelFile>(&model_)) model.imu = *causal;
    if (adapt_ && model.imu) {
      const Progress progress = terminal_progress(title);
      if (!progress(0, "learning the wearer")) return fail(ErrorCode::cancelled, "stopped while solving");
      MIEN_TRY_ASSIGN(adapted, adapt(take, *model.imu));
    }
    for (const Shaping& settings : shaping) {
      const std::string numbered =
          shaping.size() > 1 ? fmt::format("{}, {} of {}", title, out.size() + 1, shaping.size()) : title;
      MIEN_TRY_ASSIGN(out.emplace_back(), solve::replay_take(take, model, terminal_progress(numbered),
                                                             settings.value_or(shaping::ShaperSettings{})));
      out.back().personalised = adapted.personalised;
      out.back().personalise_s = adapted.seconds;
      out.back().unlearnt = adapted.unlearnt;
    }
  }
  warn_of_missing_sensors(take, out.front());
  return out;
}

void ModelOption::add_to(Command command) {
  command.add_option("--model", path,
                     "Model file, of any kind (default: the one that a live session of the take's sensors "
                     "uses, which goes frame by frame)");
  command
      .add_option("--steps", steps,
                  "Denoising steps a window of a window model; 1000 is the published sampler (default: the "
                  "model's own)")
      .in_range(1, 1000);
  command.add_flag("--window", window,
                   "The window model, models/default.safetensors: two seconds at a time, which sees what "
                   "comes later, as no session can");
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

void ShapingOption::add_to(Command command) {
  command.add_option("--shaping", path,
                     "Shape the frames as a session with these settings would: a JSON file, {} for the "
                     "defaults (docs/reference/shaping_settings.md). Without it by the defaults; a window "
                     "model's answer is not shaped");
}

Result<std::optional<shaping::ShaperSettings>> ShapingOption::read() const {
  if (path.empty()) return std::nullopt;
  MIEN_TRY_ASSIGN(const std::string text, read_text(path));
  MIEN_TRY_ASSIGN(const shaping::ShaperSettings settings, shaping::parse_settings(text, path));
  return settings;
}

}  // namespace mien::app
