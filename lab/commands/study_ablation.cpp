#include "lab/commands/studies.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

#include "app/child_program.h"
#include "app/chosen_face.h"
#include "app/json_output.h"
#include "app/performance.h"
#include "app/seed_option.h"
#include "lab/columns.h"
#include "lab/commands/output.h"
#include "lab/commands/short_trainings.h"
#include "lab/imu/ablation/ablation_study.h"
#include "mien/core/files.h"
#include "mien/dataset/training_takes.h"

namespace mien::lab {
namespace {

struct StudyAblationOptions {
  AblationRequest request;
  std::string rig, takes, splits;
  std::vector<std::string> motions;
  std::string face = "builtin";
  bool no_shipped = false;
  bool quick = false;
  Output to;
};

/// Less of everything, in two minutes: enough to see that it works, too little to compare anything.
void make_quick(AblationRequest& request) {
  request.seeds = std::min<std::size_t>(request.seeds, 2);
  request.steps = std::min<std::size_t>(request.steps, 12);
  request.data.performers = std::min(request.data.performers, 20);
  request.data.validation_performers = 2;
  request.data.seconds = request.data.device_seconds = 6;
  request.test_people = std::min<std::size_t>(request.test_people, 2);
  request.test_seconds = 6;
}

/// Of the quick study: those that the rig has sensors for.
std::vector<std::string> quick_rows(const sensor::Rig& rig, bool takes) {
  std::vector<std::string> names;
  for (const AblationRow& row : ablation_rows(rig, takes))
    for (const char* quick : {"five_sensors", "tenth_of_people", "takes_too", "diffusion", "no_overlap"})
      if (row.name == quick) names.push_back(row.name);
  return names;
}

app::Json to_json(const AblationStudy& study, const AblationResult& result) {
  app::Json out = {{"name", result.row.name},
                   {"group", result.row.group},
                   {"title", result.row.title},
                   {"sensors", result.row.sensors},
                   {"parameters", result.parameters},
                   {"bound", {{"mse", result.bound_mse}, {"pve_mm", result.bound_pve_mm}}},
                   {"tests", app::Json::object()}};
  for (std::size_t s = 0; s < kTestSetCount; ++s) {
    const auto set = static_cast<TestSet>(s);
    const SeedErrors& errors = result.on(set);
    if (errors.empty()) continue;
    app::Json& test = out["tests"][std::string(ablation_test_name(set))];
    const auto of = [&](measure::SeedFigures SeedErrors::*measure) {
      return interval_json(measure::mean_interval(figures_of(result, set, measure)));
    };
    const auto change = [&](measure::SeedFigures SeedErrors::*measure) {
      const std::optional<measure::Interval> changed = change_of(study, result, set, measure);
      return changed ? interval_json(*changed) : app::Json();
    };
    test = {{"pve_mm", of(&SeedErrors::pve_mm)},
            {"lmk_mm", of(&SeedErrors::lmk_mm)},
            {"mse", of(&SeedErrors::mse)},
            {"jitter_ratio", measure::mean_interval(errors.jitter).mean},
            {"pve_mm_by_seed_and_person", errors.pve_mm},
            {"mse_by_seed_and_person", errors.mse},
            {"pve_change", change(&SeedErrors::pve_mm)},
            {"mse_change", change(&SeedErrors::mse)}};
  }
  return out;
}

app::Json to_json(const AblationStudy& study, const StudyAblationOptions& options) {
  const AblationRequest& request = options.request;
  app::Json out = {{"rig", options.rig},
                   {"seed", request.seed},
                   {"seeds", request.seeds},
                   {"steps", request.steps},
                   {"quick", options.quick},
                   {"training_people", study.training_people},
                   {"training_minutes", study.training_minutes},
                   {"test_people", request.test_people},
                   {"takes", options.takes},
                   {"motions", options.motions},
                   {"face", options.face},
                   {"rows", app::Json::array()},
                   {"shipped", app::Json::array()}};
  for (const AblationResult& row : study.rows) out["rows"].push_back(to_json(study, row));
  for (const AblationResult& row : study.shipped) out["shipped"].push_back(to_json(study, row));
  return out;
}

/// What networks learn from is nothing to try them on.
Result<void> check_not_learnt_from(const std::string& motion, const std::string& takes) {
  if (takes.empty()) return {};
  std::error_code code;
  const std::filesystem::path inside =
      std::filesystem::weakly_canonical(motion, code)
          .lexically_relative(std::filesystem::weakly_canonical(takes, code));
  if (inside.empty() || *inside.begin() == "..") return {};
  return fail(ErrorCode::bad_usage, "it is among the --takes that networks learn from", motion,
              "try them on a recording that is not");
}

Result<void> load_motions(StudyAblationOptions& options) {
  if (options.motions.empty()) return {};
  for (const std::string& path : options.motions) MIEN_TRY(check_not_learnt_from(path, options.takes));
  MIEN_TRY_ASSIGN(const face::Face face, app::chosen_face(options.face, app::face_progress(options.face)));
  for (const std::string& path : options.motions) {
    MIEN_TRY_ASSIGN(app::Performance performance, app::load_performance(path));
    options.request.recorded.push_back({std::move(performance.motion), face});
  }
  return {};
}

/// Those whose sensors the rig has all; others are left out, and that is said.
Result<void> load_shipped(const sensor::Rig& rig, AblationRequest& request) {
  for (const auto& [name, part] : {std::pair("the shipped live model", "models/live.safetensors"),
                                   std::pair("the shipped window model", "models/default.safetensors")}) {
    MIEN_TRY_ASSIGN(const std::filesystem::path path, find_resource(part));
    MIEN_TRY_ASSIGN(model::ModelFile file, model::read_model(path));
    const std::vector<std::string> sensors = rig.face_sensor_names();
    const bool has_all = std::ranges::all_of(file.features.sensors, [&](const std::string& sensor) {
      return std::ranges::find(sensors, sensor) != sensors.end();
    });
    if (!has_all) {
      fmt::print(stderr, "mien: {} reads sensors that the rig has not, and is left out\n", name);
      continue;
    }
    request.shipped.push_back({name, std::move(file)});
  }
  return {};
}

Result<void> run_study_ablation(StudyAblationOptions options) {
  AblationRequest& request = options.request;
  MIEN_TRY_ASSIGN(request.rig, app::path_or(options.rig, "rigs/default.toml"));
  options.rig = request.rig.string();
  request.takes = options.takes;
  request.splits = options.splits;
  request.data.seed = recipe_seed(request.seed);
  if (options.quick) make_quick(request);
  // Before hours of work.
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(request.rig));
  if (options.quick && request.rows.empty()) request.rows = quick_rows(rig, !request.takes.empty());
  MIEN_TRY(chosen_rows(rig, !request.takes.empty(), request.rows));
  MIEN_TRY(app::find_helper("mien-train"));
  MIEN_TRY(load_motions(options));
  if (!request.takes.empty())
    MIEN_TRY(dataset::read_training_takes(request.takes, request.splits, rig, request.seed,
                                          app::terminal_progress("takes")));
  if (!options.no_shipped) MIEN_TRY(load_shipped(rig, request));
  request.tell = [](const std::string& sentence) {
    app::clear_progress();
    fmt::print(stderr, "mien: {}\n", sentence);
  };
  MIEN_TRY_ASSIGN(const TrainShort train,
                  train_by_helper(std::filesystem::path(options.to.out) / "trainings"));

  MIEN_TRY_ASSIGN(const AblationStudy study,
                  study_ablation(request, train, app::terminal_progress("ablation")));
  const std::string subtitle =
      fmt::format("{} trainings a row of {} steps, seed {}{}", request.seeds, request.steps, request.seed,
                  options.quick ? "; quick, compares nothing" : "");
  return put_out_in_folder(options.to, "ablation", ablation_report(study, options.takes, subtitle),
                           to_json(study, options));
}

}  // namespace

void add_study_ablation(app::Commands& commands, app::Command study) {
  auto options = std::make_shared<StudyAblationOptions>();
  const app::Command command = commands.add_under(
      study, "ablation",
      "What fewer sensors, less data and other networks cost, by short trainings (needs mien-train)",
      "mien study ablation --out ablation\n  mien study ablation --rows five_sensors --out five",
      [options] { return run_study_ablation(*options); });
  AblationRequest& request = options->request;
  command.add_option(
      "--rows", request.rows,
      "Only these rows, by name, and the base (default: all, an hour or two of two cores): five_sensors, "
      "five_upper, no_frontalis, no_orbicularis, "
      "no_zygomaticus, no_buccinator, one_side, third_of_people, tenth_of_people, no_difference, "
      "transformer, diffusion, no_overlap, window_30, window_60, window_240; with --takes: takes_alone, "
      "takes_too");
  add_short_training_options(command, {.seeds = request.seeds,
                                       .steps = request.steps,
                                       .data = request.data,
                                       .test_people = request.test_people});
  const app::Option takes = command.add_option(
      "--takes", options->takes, "Folder of people's takes with a phone's truth, for the rows of takes");
  command
      .add_option("--splits", options->splits,
                  "File of who of the takes is trained on and who validated on, as `mien dataset` writes it")
      .needs(takes);
  const app::Option motions =
      command.add_option("--motion", options->motions,
                         "A recorded performance to try all rows on: a Live Link Face CSV or "
                         "a take; may be given often");
  command.add_option("--face", options->face, "Face of the --motion, as mien face takes it")
      .needs(motions)
      .show_default();
  app::add_rig_option(command, options->rig);
  command.add_flag("--no-shipped", options->no_shipped, "Leave the shipped models out of the table");
  app::add_seed_option(command, request.seed, "Of all people, and of the trainings");
  command.add_flag("--quick", options->quick,
                   "Few rows, people and steps, in a minute: shows that it works, compares nothing");
  command
      .add_option("--out", options->to.out,
                  "Folder for ablation.html, ablation.txt and ablation.json, made where it is not; its "
                  "`trainings` keep what is trained, so that a study that was stopped goes on; a gigabyte of "
                  "memory a core")
      .required();
  app::add_json_flag(command, options->to.json);
}

}  // namespace mien::lab
