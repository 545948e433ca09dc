#include "lab/commands/studies.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "app/chosen_face.h"
#include "app/json_output.h"
#include "app/performance.h"
#include "app/private_folder.h"
#include "app/seed_option.h"
#include "lab/commands/output.h"
#include "lab/imu/live_study.h"
#include "mien/core/files.h"
#include "mien/model/model_file.h"

namespace mien::lab {
namespace {

struct StudyLiveOptions {
  LiveRequest request;
  std::vector<std::string> rows;
  std::vector<std::string> takes;
  std::string face = "builtin";
  std::string rig;
  std::string live;
  std::string window;
  std::vector<std::size_t> steps = {10, 5, 1};
  std::vector<std::string> models;  // NAME=FILE.
  bool quick = false;
  Output to;
  std::vector<std::string> skipped;  // Takes and faces that are not here.
};

/// Whether a file of the user's is here. What is not is said, and left out.
bool is_here(const std::string& path, StudyLiveOptions& options) {
  std::error_code code;
  if (path == "builtin" || std::filesystem::exists(path, code)) return true;
  fmt::print(stderr, "mien: {} is not here: its rows are left out\n", path);
  options.skipped.push_back(path);
  return false;
}

Result<void> load_takes(StudyLiveOptions& options) {
  if (options.takes.empty() || !is_here(options.face, options)) return {};
  std::vector<std::string> names;
  for (const std::string& path : options.takes) {
    if (!is_here(path, options)) continue;
    MIEN_TRY_ASSIGN(app::Performance performance, app::load_performance(path));
    options.request.motions.push_back({std::move(performance.motion), 0});
    names.push_back(std::filesystem::path(path).stem().string());
  }
  if (names.empty()) return {};
  MIEN_TRY_ASSIGN(options.request.faces.emplace_back(),
                  app::chosen_face(options.face, app::terminal_progress("face")));
  const std::filesystem::path face = options.face;
  const std::string face_name = (face.has_filename() ? face : face.parent_path()).filename().string();
  options.request.motions_are = fmt::format("{} on the face {}", fmt::join(names, ", "), face_name);
  return {};
}

/// "NAME=FILE".
Result<LiveModels::Causal> load_named(const std::string& named) {
  const std::size_t sign = named.find('=');
  if (sign == std::string::npos || sign == 0 || sign + 1 == named.size())
    return fail(ErrorCode::bad_usage, "a model to compare is NAME=FILE", named);
  MIEN_TRY_ASSIGN(model::ModelFile file, model::read_model(named.substr(sign + 1)));
  return LiveModels::Causal{named.substr(0, sign), std::move(file)};
}

Result<LiveModels> load_models(StudyLiveOptions& options, std::optional<tracker::WindowSolver>& window) {
  LiveModels models;
  MIEN_TRY_ASSIGN(options.live, app::path_or(options.live, "models/live.safetensors"));
  MIEN_TRY_ASSIGN(options.window, app::path_or(options.window, "models/default.safetensors"));
  MIEN_TRY_ASSIGN(model::ModelFile live, model::read_model(options.live));
  models.causal.push_back({"live", std::move(live)});
  for (const std::string& named : options.models) {
    MIEN_TRY_ASSIGN(LiveModels::Causal model, load_named(named));
    const bool twice =
        std::ranges::find(models.causal, model.name, &LiveModels::Causal::name) != models.causal.end();
    if (twice) return fail(ErrorCode::bad_usage, "two models have one name", model.name);
    models.causal.push_back(std::move(model));
  }
  MIEN_TRY_ASSIGN(model::ModelFile file, model::read_model(options.window));
  MIEN_TRY_ASSIGN(window, tracker::WindowSolver::create(std::move(file)));
  models.window = &*window;
  models.window_steps = options.steps;
  return models;
}

app::Json to_json(const LiveMethod& method) {
  app::Json out = {{"name", method.name}};
  for (std::size_t m = 0; m < kMeasureCount; ++m) {
    const std::optional<measure::MeanStd> value = method.over(static_cast<Measure>(m));
    app::Json& figure = out[std::string(kMeasures[m].name)];
    if (!value) continue;
    figure = {{"mean", value->mean}, {"std", value->std}, {"performers", app::Json::array()}};
    for (const Figures& figures : method.performers) figure["performers"].push_back(or_null(figures[m]));
  }
  return out;
}

app::Json to_json(const LiveSet& set) {
  app::Json out = {{"who", set.who}, {"rows", app::Json::array()}};
  for (const LiveRow& row : set.rows) {
    app::Json methods = app::Json::array();
    for (const LiveMethod& method : row.methods) methods.push_back(to_json(method));
    out["rows"].push_back({{"condition", names_of(row.condition).name},
                           {"title", row.title},
                           {"performers", row.methods.front().performers.size()},
                           {"frames", row.frames},
                           {"observed", row.observed},
                           {"rotation_rms_deg", row.rotation_rms_deg},
                           {"methods", std::move(methods)}});
  }
  return out;
}

app::Json to_json(const LiveStudy& study, const StudyLiveOptions& options, const sensor::Rig& rig) {
  app::Json out = {{"rig", rig.name},
                   {"seed", options.request.seed},
                   {"performers", options.request.performers},
                   {"seconds", options.request.seconds},
                   {"live", options.live},
                   {"window", options.window},
                   {"models", options.models},
                   {"takes", options.takes},
                   {"face", options.face},
                   {"skipped", options.skipped},
                   {"sets", app::Json::array()}};
  for (const LiveSet& set : study.sets) out["sets"].push_back(to_json(set));
  return out;
}

/// Less of everything, in a minute or two.
void make_quick(LiveRequest& request) {
  request.performers = std::min(request.performers, 2);
  request.seconds = std::min(request.seconds, 15.0);
  request.given_seconds = 15;
  request.round_s = 10;
}

Result<void> run_study_live(StudyLiveOptions options) {
  for (const std::string& row : options.rows) {
    MIEN_TRY_ASSIGN(options.request.conditions.emplace_back(), parse_live_condition(row));
  }
  MIEN_TRY_ASSIGN(options.rig, app::path_or(options.rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(options.rig));
  MIEN_TRY_ASSIGN(const std::filesystem::path other, find_resource("rigs/another_simulator.toml"));
  MIEN_TRY_ASSIGN(const std::string other_toml, read_text(other));
  MIEN_TRY_ASSIGN(options.request.other_faults, virt::parse_faults(other_toml, other.string()));
  std::optional<tracker::WindowSolver> window;
  MIEN_TRY_ASSIGN(const LiveModels models, load_models(options, window));
  if (options.quick) make_quick(options.request);
  MIEN_TRY(load_takes(options));
  if (options.request.performers == 0 && options.request.motions.empty())
    return fail(ErrorCode::bad_usage, "nobody performs", "study live",
                "give --takes that are here, or --performers above 0");
  MIEN_TRY(app::make_private_folders(options.to.out));

  MIEN_TRY_ASSIGN(const LiveStudy study,
                  study_live(options.request, rig, models, app::terminal_progress("live")));
  const std::string subtitle =
      fmt::format("model {} beside {}, seed {}", std::filesystem::path(options.live).filename().string(),
                  std::filesystem::path(options.window).filename().string(), options.request.seed);
  return put_out_in_folder(options.to, "live", live_report(study, subtitle), to_json(study, options, rig));
}

}  // namespace

void add_study_live(app::Commands& commands, app::Command study) {
  auto options = std::make_shared<StudyLiveOptions>();
  const app::Command command = commands.add_under(
      study, "live",
      "How accurate the live model is beside all others, on the same takes under many conditions",
      "mien study live --out live\n  mien study live --takes a.csv b.csv --face FaceXModel --out live",
      [options] { return run_study_live(*options); });
  LiveRequest& request = options->request;
  command.add_option(
      "--rows", options->rows,
      "Only these conditions, by name: lab, seen, unseen, remount, walking, running, eating, rapid, "
      "one_lost, three_lost, bursts, other_simulator, long_session");
  command.add_option("--performers", request.performers, "Virtual performers; 0: the takes alone")
      .in_range(0, 10000)
      .show_default();
  command.add_option("--seconds", request.seconds, "Length of each virtual performance after the prologue")
      .number_between(1.0, 3600.0)
      .show_default();
  const app::Option takes =
      command.add_option("--takes", options->takes,
                         "Performances to play as well: Live Link Face CSVs, or takes with "
                         "truth; one that is not here is left out");
  command.add_option("--face", options->face, "Face of the --takes, as mien face takes it")
      .needs(takes)
      .show_default();
  command.add_option("--live", options->live, "The live model (default: models/live.safetensors)");
  command.add_option("--window", options->window, "The window network (default: models/default.safetensors)");
  command
      .add_option(
          "--steps", options->steps,
          "Denoising steps that the window network is asked with; 1000 is the published sampler, and takes "
          "half an hour of a core for a row of two minutes")
      .in_range(1, 1000)
      .show_default();
  command.add_option("--model", options->models, "Another causal model, as NAME=FILE; may be given often");
  app::add_rig_option(command, options->rig);
  app::add_seed_option(command, request.seed, "Of the performers, their devices and the networks");
  command.add_flag("--quick", options->quick, "Fewer and shorter performances, for a first look");
  command
      .add_option("--out", options->to.out,
                  "Folder for live.html, live.txt and live.json; made where it is not")
      .required();
  app::add_json_flag(command, options->to.json);
}

}  // namespace mien::lab
