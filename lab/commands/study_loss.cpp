#include "lab/commands/studies.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <utility>

#include "app/chosen_face.h"
#include "app/command.h"
#include "app/json_output.h"
#include "app/performance.h"
#include "app/seed_option.h"
#include "lab/commands/output.h"
#include "lab/imu/loss.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"

namespace mien::lab {
namespace {

struct StudyLossOptions {
  LossRequest request;
  std::string model;
  std::string rig;
  std::vector<std::string> motions;
  std::vector<std::string> faces;
  std::vector<std::string> rows;
  Output to;
};

/// Reads the motions, and every face once.
Result<void> load_motions(StudyLossOptions& options) {
  if (options.faces.empty()) options.faces = {"builtin"};
  if (options.faces.size() > 1 && options.faces.size() != options.motions.size())
    return fail(ErrorCode::bad_usage,
                fmt::format("{} faces for {} motions", options.faces.size(), options.motions.size()), "loss",
                "give one --face for all, or one for each --motion");
  std::vector<std::string> read;
  for (std::size_t m = 0; m < options.motions.size(); ++m) {
    const std::string& face = options.faces[std::min(m, options.faces.size() - 1)];
    const auto known = std::ranges::find(read, face);
    const auto place = static_cast<std::size_t>(known - read.begin());
    if (known == read.end()) {
      MIEN_TRY_ASSIGN(options.request.faces.emplace_back(), app::chosen_face(face));
      read.push_back(face);
    }
    MIEN_TRY_ASSIGN(app::Performance performance, app::load_performance(options.motions[m]));
    options.request.motions.push_back({std::move(performance.motion), place});
  }
  return {};
}

/// All conditions, or those whose name has one of the texts of --rows in it.
Result<std::vector<LossCondition>> chosen_conditions(const StudyLossOptions& options,
                                                     const sensor::Rig& rig) {
  const std::vector<LossCondition> all = loss_conditions(rig);
  const auto has = [](const std::string& text) {
    return [&text](const LossCondition& one) { return one.name().find(text) != std::string::npos; };
  };
  for (const std::string& row : options.rows)
    if (std::ranges::none_of(all, has(row)))
      return fail(ErrorCode::bad_usage, "no condition has this in its name",
                  "--rows " + app::one_line(row, 40),
                  "the table of mien study loss --performers 1 --seconds 1 names them all");
  std::vector<LossCondition> chosen;
  std::ranges::copy_if(all, std::back_inserter(chosen), [&](const LossCondition& one) {
    return options.rows.empty() ||
           std::ranges::any_of(options.rows, [&](const std::string& row) { return has(row)(one); });
  });
  return chosen;
}

std::string performed_by(const StudyLossOptions& options) {
  if (options.motions.empty())
    return fmt::format("{} virtual performers of {:g} s, seed {}", options.request.performers,
                       options.request.seconds, options.request.seed);
  return fmt::format("{} recorded performance{}, seed {}", options.motions.size(),
                     options.motions.size() == 1 ? "" : "s", options.request.seed);
}

app::Json to_json(const LossStudy& study, const StudyLossOptions& options, const sensor::Rig& rig) {
  app::Json out = {{"model", options.model}, {"rig", rig.name}, {"seed", options.request.seed}};
  if (options.motions.empty()) {
    out["performers"] = options.request.performers;
    out["seconds"] = options.request.seconds;
  } else {
    out["motions"] = options.motions;
    out["faces"] = options.faces;
  }
  const LossRow* tenth = study.find(Fault::loss, 10);
  const LossRow* worst = study.worst_sensor();
  out["rise_at_10_percent"] = tenth != nullptr ? app::Json(tenth->rise) : app::Json();
  out["rise_allowed_at_10_percent"] = kRiseAllowedAt10Percent;
  out["worst_sensor"] = worst != nullptr ? app::Json(worst->condition.sensor) : app::Json();
  out["worst_sensor_rise"] = worst != nullptr ? app::Json(worst->rise) : app::Json();
  out["worst_sensor_rise_allowed"] = kRiseAllowedWithoutASensor;
  out["unsound_frames"] = study.unsound();
  out["mistold_frames"] = study.mistold();
  out["kept"] = study.kept();
  out["mean_pose_mse"] = study.mean_pose_mse;
  out["rows"] = json_of(study.rows, loss_columns());
  return out;
}

Result<void> run_study_loss(StudyLossOptions options) {
  MIEN_TRY(check_page(options.to));
  MIEN_TRY_ASSIGN(options.rig, app::path_or(options.rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(options.model, app::path_or(options.model, "models/live.safetensors"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(options.rig));
  MIEN_TRY_ASSIGN(const model::ModelFile model, model::read_model(options.model));
  MIEN_TRY_ASSIGN(const std::vector<LossCondition> conditions, chosen_conditions(options, rig));
  if (!options.motions.empty()) MIEN_TRY(load_motions(options));
  MIEN_TRY_ASSIGN(const LossStudy study,
                  study_loss(options.request, rig, model, conditions, app::terminal_progress("loss")));
  const std::string subtitle = fmt::format("{}, model {}", performed_by(options),
                                           std::filesystem::path(options.model).filename().string());
  return put_out(options.to, loss_report(study, subtitle), to_json(study, options, rig));
}

}  // namespace

void add_study_loss(app::Commands& commands, app::Command study) {
  auto options = std::make_shared<StudyLossOptions>();
  const app::Command command = commands.add_under(
      study, "loss", "How accurate the live model stays with lost packets, bad networks and silent sensors",
      "mien study loss --performers 24 --out loss.html", [options] { return run_study_loss(*options); });
  command.add_option("--model", options->model, "Live model (default: models/live.safetensors)");
  app::add_rig_option(command, options->rig);
  const app::Option performers =
      command.add_option("--performers", options->request.performers, "Virtual performers")
          .in_range(1, 10000)
          .show_default();
  const app::Option seconds = command
                                  .add_option("--seconds", options->request.seconds,
                                              "Length of each virtual performance after the prologue")
                                  .number_between(1.0, 3600.0)
                                  .show_default();
  const app::Option motions =
      command
          .add_option("--motion", options->motions,
                      "Perform these instead: Live Link Face CSVs, or takes with truth")
          .excludes(performers)
          .excludes(seconds);
  command
      .add_option("--face", options->faces,
                  "Face of each --motion, or one for all, as mien face takes it (default: builtin)")
      .needs(motions);
  command.add_option(
      "--rows", options->rows,
      "Only the conditions with one of these in their name, beside the clean one: bursts \"10 %\"");
  app::add_seed_option(command, options->request.seed, "Of the performers, their devices and the networks");
  command.add_option("--out", options->to.out,
                     "Write a self-contained HTML page with the curve and the table");
  app::add_json_flag(command, options->to.json);
}

}  // namespace mien::lab
