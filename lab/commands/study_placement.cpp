#include "lab/commands/studies.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <numeric>
#include <system_error>
#include <utility>

#include "app/chosen_face.h"
#include "app/command.h"
#include "app/json_output.h"
#include "app/private_folder.h"
#include "app/seed_option.h"
#include "lab/columns.h"
#include "lab/commands/output.h"
#include "lab/commands/short_trainings.h"
#include "lab/imu/placement/placement_study.h"
#include "lab/imu/placement/sensor_candidates.h"
#include "mien/core/files.h"
#include "mien/core/units.h"

namespace mien::lab {
namespace {

struct PlacementOptions {
  PlacementRequest request;
  std::string rig;
  double grid_mm = 8;
  std::string face = "builtin";
  std::string objective = "vertex";
  double noise_deg = 1;
  bool one_sided = false;
  std::string write_rig;
  bool force = false;
  bool no_training = false;
  Output to;
};

/// Less of everything, in a minute: enough to see that it works, too little to compare anything.
void make_quick(PlacementRequest& request) {
  request.paper_sites.performers = 4;
  request.skin.performers = 100;
  request.skin.seconds = 15;
  request.picture_px = 240;
  PlacementTrainingRequest& training = request.training;
  training.seeds = std::min<std::size_t>(training.seeds, 2);
  training.steps = std::min<std::size_t>(training.steps, 30);
  training.data.performers = std::min(training.data.performers, 24);
  training.data.validation_performers = 2;
  training.data.seconds = 8;
  training.data.device_seconds = 8;
  training.data.device_share = 0.25;
  training.test_people = std::min<std::size_t>(training.test_people, 4);
  training.test_seconds = 8;
}

void seed_placement(PlacementRequest& request) {
  request.paper_sites.seed = request.training.seed = request.seed;
  request.training.data.seed = recipe_seed(request.seed);
}

PlacementObjective objective_of(const std::string& name) {
  if (name == "mse") return PlacementObjective::mse;
  return name == "groups" ? PlacementObjective::groups : PlacementObjective::vertex;
}

app::Json to_json(const PaperAgreement& agreement) {
  return {{"areas", agreement.areas}, {"all", agreement.all}};
}

app::Json paper_json(const PaperSitesStudy& felt) {
  app::Json sites = app::Json::array();
  for (const PaperSiteFelt& site : felt.sites)
    sites.push_back({{"area", site.site.area},
                     {"number", site.site.number},
                     {"used", site.site.used},
                     {"paper", site.site.variation},
                     {"acceleration_m2_s4", site.acceleration},
                     {"accelerometer_m2_s4", site.accelerometer},
                     {"rotation_deg", site.rotation_deg}});
  return {{"sites", std::move(sites)},
          {"rank_correlation",
           {{"acceleration", to_json(felt.acceleration)},
            {"accelerometer", to_json(felt.accelerometer)},
            {"rotation", to_json(felt.rotation)}}}};
}

app::Json to_json(const PlacementStudy& study, const PlacementOptions& options) {
  app::Json out = {{"face", options.face},
                   {"seed", options.request.seed},
                   {"objective", options.objective},
                   {"prior", options.request.settings.prior},
                   {"noise_deg", options.noise_deg},
                   {"grid_mm", options.grid_mm},
                   {"one_sided", options.one_sided},
                   {"quick", options.request.quick},
                   {"left_right", study.left_right},
                   {"paper", json_of(study.paper, placement_columns())},
                   {"paper_five", json_of(study.paper_five, placement_columns())},
                   {"sets", json_of(study.sets, placement_columns())}};
  out["chosen"] = app::Json::array();
  for (const std::size_t i : study.chosen) out["chosen"].push_back(study.candidates[i].name);
  out["paper_table"] = paper_json(study.paper_sites);
  const PlacementTrainingRequest& training = options.request.training;
  out["amounts"] = {{"seeds", training.seeds},
                    {"steps", training.steps},
                    {"performers", training.data.performers},
                    {"test_people", training.test_people}};
  out["not_trained"] = study.not_trained.empty() ? app::Json() : app::Json(study.not_trained);
  out["trained"] = json_of(study.trained, trained_columns());
  out["contests"] = app::Json::array();
  for (const PlacementContest& one : study.contests)
    out["contests"].push_back({{"ours", one.ours},
                               {"paper", one.paper},
                               {"device", interval_json(one.device)},
                               {"lab", interval_json(one.lab)},
                               {"device_mse", interval_json(one.device_mse)},
                               {"lab_mse", interval_json(one.lab_mse)},
                               {"verdict", options.request.quick ? app::Json() : app::Json(one.verdict())}});
  std::vector<std::size_t> all(study.candidates.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  out["candidates"] = json_of(all, candidate_columns(study));
  return out;
}

Result<PlacementRigs> placement_rigs(const PlacementOptions& options) {
  PlacementRigs rigs;
  MIEN_TRY_ASSIGN(const std::filesystem::path candidates, find_resource("rigs/candidates.toml"));
  MIEN_TRY_ASSIGN(rigs.paper_candidates, sensor::read_rig(candidates));
  MIEN_TRY_ASSIGN(const std::filesystem::path paper, find_resource("rigs/default.toml"));
  MIEN_TRY_ASSIGN(rigs.paper, sensor::read_rig(paper));
  if (!options.rig.empty()) {
    MIEN_TRY_ASSIGN(rigs.own, sensor::read_rig(options.rig));
    rigs.own->name = options.rig;  // What errors say of its sensors is of this file.
    MIEN_TRY(candidates_of(*rigs.own));
  }
  return rigs;
}

/// Before long work: whether the rig may be written.
Result<void> check_written_rig(const PlacementOptions& options) {
  if (options.write_rig.empty()) return {};
  MIEN_TRY(app::check_output(options.write_rig, {".toml"}));
  std::error_code ignored;
  if (!options.force && std::filesystem::exists(options.write_rig, ignored))
    return fail(ErrorCode::bad_usage, "it exists already", options.write_rig, "use --force to replace it");
  return {};
}

/// The winner as a rig, and how it comes to live, its model by `recipe_text`.
Result<std::string> write_winner(const PlacementOptions& options, const PlacementRigs& rigs,
                                 const PlacementStudy& study, const std::filesystem::path& folder,
                                 const std::string& recipe_text) {
  const std::string name = std::filesystem::path(options.write_rig).stem().string();
  MIEN_TRY_ASSIGN(const sensor::Rig rig,
                  worn_rig_of(study.chosen_candidates(), rigs.paper, app::one_line(name), {},
                              app::terminal_progress("skin")));
  app::clear_progress();
  const std::string text =
      fmt::format(
          "# {} IMUs on the face and the head's, chosen by mien study placement (seed {}, {}). Order fixes "
          "the sensors' numbers;\n# `device` binds the virtual nodes of `mien perform --to`.\n",
          study.chosen.size(), options.request.seed, options.objective) +
      sensor::write_rig(rig);
  MIEN_TRY_ASSIGN(const sensor::Rig back, sensor::parse_rig(text, options.write_rig));
  if (sensor::write_rig(back) != sensor::write_rig(rig))
    return fail(ErrorCode::internal, "the rig does not read back", options.write_rig);
  MIEN_TRY(write_file(options.write_rig, text));
  const std::filesystem::path recipe = folder / "recipe.toml";
  MIEN_TRY(write_file(recipe, recipe_text));
  const std::string model =
      std::filesystem::path(options.write_rig).replace_extension(".safetensors").string();
  return fmt::format(
      "rig: {0}\nIts model, by the recipe {1}:\n\n{2}\n"
      "  mien train {1} --rig {0} --out {3} --threads 1\n"
      "  mien live --rig {0} --model {3}\n"
      "  mien perform --rig {0} --to udp://127.0.0.1:5005\n",
      options.write_rig, recipe.string(), recipe_text, model);
}

Result<void> run_study_placement(PlacementOptions options) {
  MIEN_TRY(check_written_rig(options));
  MIEN_TRY_ASSIGN(const std::filesystem::path shipped, find_resource("models/recipes/placement.toml"));
  MIEN_TRY_ASSIGN(const std::string recipe_text, read_text(shipped));
  options.request.spacing_m = options.grid_mm / kMmPerM;
  options.request.objective = objective_of(options.objective);
  options.request.settings.noise_rad = options.noise_deg * kRadPerDeg;
  options.request.settings.one_sided = options.one_sided;
  if (options.request.quick) make_quick(options.request);
  seed_placement(options.request);
  MIEN_TRY_ASSIGN(const PlacementRigs rigs, placement_rigs(options));
  MIEN_TRY_ASSIGN(const face::Face face, app::chosen_face(options.face, app::face_progress(options.face)));
  const std::filesystem::path folder = options.to.out;
  TrainShort train;
  if (!options.no_training) {
    MIEN_TRY_ASSIGN(train, train_by_helper(folder / "trainings"));
  }

  MIEN_TRY_ASSIGN(const PlacementStudy study,
                  study_placement(options.request, face, rigs, train ? &train : nullptr,
                                  app::terminal_progress("placement")));
  app::clear_progress();
  MIEN_TRY(app::make_private_folders(folder));
  std::string written;
  if (!options.write_rig.empty()) {
    MIEN_TRY_ASSIGN(written, write_winner(options, rigs, study, folder, recipe_text));
  }
  const std::string subtitle =
      fmt::format("{} sensors on {}, seed {}{}", options.request.sensors, app::one_line(options.face),
                  options.request.seed, options.request.quick ? "; quick, compares nothing" : "");
  MIEN_TRY(render::write_png(folder / "placement.png", study.picture));
  MIEN_TRY_ASSIGN(const measure::Report report, placement_report(study, options.request, subtitle));
  if (options.to.json) {
    if (!study.not_trained.empty()) fmt::print(stderr, "mien: {}\n", study.not_trained);
    fmt::print(stderr, "{}", written);
  }
  return put_out_in_folder(options.to, "placement", report, to_json(study, options), written);
}

}  // namespace

void add_study_placement(app::Commands& commands, app::Command study) {
  auto options = std::make_shared<PlacementOptions>();
  const app::Command command = commands.add_under(
      study, "placement",
      "Where on the face sensors tell most, for any number of them (needs mien-train unless --no-training)",
      "mien study placement --out placement\n"
      "  mien study placement --sensors 5 --no-training --write-rig five.toml --out five",
      [options] { return run_study_placement(*options); });
  PlacementRequest& request = options->request;
  command.add_option(
      "--rig", options->rig,
      "One's own candidates: the IMUs of a rig, instead of the paper's and a grid of the skin");
  command.add_option("--grid", options->grid_mm, "Distance of the grid's places, mm")
      .number_between(3.0, 50.0)
      .show_default();
  command.add_option("--face", options->face, "Whose skin the bound is of, as mien face takes it")
      .show_default();
  command.add_option("--sensors", request.sensors, "Sensors of the set that is drawn and written, 1 to 16")
      .in_range(1, 16)
      .show_default();
  command
      .add_option(
          "--objective", options->objective,
          "What becomes least: vertex (displacement of the skin), mse (of the weights), groups (of the "
          "weights; brows, eyes, cheeks, mouth and jaw alike)")
      .one_of({"vertex", "mse", "groups"})
      .show_default();
  command.add_option("--prior", request.settings.prior, "Standard deviation of each weight beforehand")
      .number_between(1e-3, 10.0)
      .show_default();
  command.add_option("--noise", options->noise_deg, "Noise of each orientation, degrees an axis")
      .number_between(1e-3, 90.0)
      .show_default();
  command.add_flag("--one-sided", options->one_sided,
                   "Each side for itself; else pairs of mirror images and the midline");
  const app::Option written = command.add_option(
      "--write-rig", options->write_rig,
      "Write the chosen set as a rig (.toml) with a [skin] of its own, which takes another minute");
  command.add_flag("--force", options->force, "Replace --write-rig where it exists").needs(written);
  command.add_flag("--no-training", options->no_training,
                   "The linear bound alone: a quarter of a minute instead of half an hour");
  command.add_flag("--quick", request.quick,
                   "Few people and steps, in a minute: shows that it works, compares nothing");
  PlacementTrainingRequest& training = request.training;
  add_short_training_options(command, {.seeds = training.seeds,
                                       .steps = training.steps,
                                       .data = training.data,
                                       .test_people = training.test_people,
                                       .fewest_people = 2});
  app::add_seed_option(command, request.seed, "Of the people and the networks");
  command
      .add_option(
          "--out", options->to.out,
          "Folder for placement.html, .txt, .json and .png, and for what is trained; made where it is "
          "not")
      .required();
  app::add_json_flag(command, options->to.json);
}

}  // namespace mien::lab
