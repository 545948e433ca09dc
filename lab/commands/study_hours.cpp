#include "lab/commands/study_hours.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/chosen_face.h"
#include "app/command.h"
#include "app/json_output.h"
#include "app/performance.h"
#include "lab/commands/hours_figures.h"
#include "lab/imu/hours_study.h"
#include "lab/imu/hours_summary.h"
#include "mien/core/cache_folder.h"
#include "mien/face/profile.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"

namespace mien::lab {
namespace {

/// What is performed where nothing else is asked for.
constexpr std::array kHoursScripts = {performer::Block::mixed, performer::Block::reading};

struct HoursOptions {
  HoursRequest request;
  std::vector<std::string> scripts;  ///< None, and no motion: kHoursScripts.
  std::vector<std::string> motions;
  std::string face;
  std::vector<std::string> scenarios = {"default"};
  std::vector<std::string> held;
  std::string model;
  std::string rig;
  bool json = false;
};

/// SHAPES=VALUE@BEGIN-END, shapes with a plus between them, times in minutes.
Result<performer::HeldExpression> parse_held(const std::string& text) {
  const auto wrong = [&](std::string what) {
    return fail(ErrorCode::bad_usage, std::move(what), "--held " + text,
                "give it as browDown_L+browDown_R=0.7@5-15, in minutes");
  };
  performer::HeldExpression held;
  const std::size_t equals = text.find('='), at = text.find('@'),
                    dash = text.find('-', at == std::string::npos ? 0 : at);
  if (equals == std::string::npos || at == std::string::npos || dash == std::string::npos || equals > at)
    return wrong("this is no held expression");
  for (std::size_t from = 0; from < equals;) {
    const std::size_t to = std::min(text.find('+', from), equals);
    held.shapes.push_back(face::shape_index(text.substr(from, to - from)));
    if (held.shapes.back() == face::kShapeCount)
      return wrong("there is no shape " + text.substr(from, to - from));
    from = to + 1;
  }
  try {
    held.value = std::stof(text.substr(equals + 1, at - equals - 1));
    held.begin_s = 60 * std::stod(text.substr(at + 1, dash - at - 1));
    held.end_s = 60 * std::stod(text.substr(dash + 1));
  } catch (const std::exception&) {
    return wrong("a number is missing");
  }
  if (!(held.value > 0 && held.value <= 1) || !(held.begin_s >= 0 && held.end_s > held.begin_s))
    return wrong("its value is in (0, 1] and it ends after it begins");
  return held;
}

void print(const HoursRun& run) {
  fmt::print("\n{}, {}, seed {}{}\n", run.script, run.scenario, run.seed,
             run.sensor.empty() ? "" : ", " + run.sensor);
  fmt::print("{:>7} {:>8} {:>8} {:>8} {:>8} {:>6} {:>8} {:>8} {:>8} {:>6} {:>8}  {}\n", "minute", "MSE",
             "lab", "known", "frozen", "ratio", "PVE mm", "rotation", "vertical", "NEES", "missing",
             run.sensor.empty() ? "largest bias" : "sensor, frozen  largest bias");
  for (const HoursPiece& piece : run.pieces) {
    fmt::print(
        "{:7.0f} {:8.4f} {:8.4f} {:8.4f} {:8.4f} {:6.2f} {:8.3f} {:7.2f}° {:7.2f}° {:6.2f} {:6.1f} %  ",
        piece.begin_s / 60, piece.mse.device, piece.mse.lab, piece.mse.known, piece.mse.frozen, piece.ratio,
        piece.pve_mm, piece.rotation_rms_deg, piece.vertical_rms_deg, piece.nees, 100 * piece.missing);
    if (!run.sensor.empty())
      fmt::print("{:5.2f}°, {:5.1f}°  ", piece.sensor_rms_deg, piece.frozen_sensor_rms_deg);
    fmt::print("{} {:+.2f}\n", face::kShapeNames[piece.worst_shape], piece.worst_bias);
    for (const HoursErrors& held : piece.held)
      fmt::print("{:>7} {:8.3f} {:8.3f} {:8.3f} {:8.3f}\n", "held", held.device, held.lab, held.known,
                 held.frozen);
  }
}

void print(const std::vector<HoursSummary>& summaries) {
  fmt::print(
      "\n{:<16} {:<12} {:>4} {:>16} {:>16} {:>8} {:>8} {:>6} {:>6} {:>6} {:>13} {:>10} {:>14} {:>14}  {}\n",
      "script", "scenario", "runs", "MSE first, last", "lab", "known", "frozen", "ratio", "<=1.3", "<=1.6",
      "rotation", "NEES", "missing", "sensor, frozen", "largest bias");
  for (const HoursSummary& one : summaries)
    fmt::print(
        "{:<16} {:<12} {:>4} {:7.4f}, {:7.4f} {:7.4f}, {:7.4f} {:8.4f} {:8.4f} {:6.2f} {:4.0f} % {:4.0f} % "
        "{:5.2f}°, {:4.2f}° {:4.2f}, {:4.2f} {:4.1f} %, {:4.1f} % {:>14}  {} {:+.2f}\n",
        one.script, one.scenario, one.runs, one.first_mse.device, one.last_mse.device, one.first_mse.lab,
        one.last_mse.lab, one.last_mse.known, one.last_mse.frozen, one.worst_ratio, 100 * one.within_most,
        100 * one.within_all, one.first_rotation_deg, one.worst_rotation_deg, one.least_nees, one.most_nees,
        100 * one.first_missing, 100 * one.worst_missing,
        one.frozen_sensor_deg > 0 ? fmt::format("{:.2f}°, {:.1f}°", one.sensor_deg, one.frozen_sensor_deg)
                                  : "",
        face::kShapeNames[one.worst_shape], one.worst_bias);
}

/// What is performed, by whom and in which scenarios.
Result<void> read_hours_request(HoursOptions& options) {
  HoursRequest& request = options.request;
  for (const std::string& script : options.scripts) {
    MIEN_TRY_ASSIGN(request.scripts.emplace_back(), performer::parse_block(script));
  }
  for (const std::string& motion : options.motions) {
    MIEN_TRY_ASSIGN(app::Performance performance, app::load_performance(motion, false));
    if (performance.motion.frames.size() < 2)
      return fail(ErrorCode::out_of_range, "nothing moves: it has fewer than two frames", motion);
    request.motions.push_back(std::move(performance.motion));
  }
  if (request.scripts.empty() && request.motions.empty())
    request.scripts.assign(kHoursScripts.begin(), kHoursScripts.end());
  if (!options.face.empty()) {
    MIEN_TRY_ASSIGN(request.face, app::chosen_face(options.face, app::face_progress(options.face)));
  }
  request.scenarios.clear();
  for (const std::string& scenario : options.scenarios) {
    MIEN_TRY_ASSIGN(request.scenarios.emplace_back(), find_hours_scenario(scenario));
  }
  for (const std::string& held : options.held) {
    MIEN_TRY_ASSIGN(request.held.emplace_back(), parse_held(held));
  }
  return {};
}

/// For the help: each scenario with what it is.
std::string hours_scenario_help() {
  std::string out = "What happens in the sessions: ";
  for (const HoursScenario& scenario : hours_scenarios())
    out += fmt::format("{}{} ({})", &scenario == hours_scenarios().data() ? "" : "; ", scenario.name,
                       scenario.description);
  return out;
}

Result<void> run_study_hours(HoursOptions options) {
  MIEN_TRY_ASSIGN(options.rig, app::path_or(options.rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(options.model, app::path_or(options.model, "models/live.safetensors"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(options.rig));
  MIEN_TRY_ASSIGN(const model::ModelFile model, model::read_model(options.model));
  MIEN_TRY(read_hours_request(options));
  std::optional<HoursCache> cache;
  if (const std::filesystem::path folder = cache_folder(); !folder.empty()) {
    MIEN_TRY_ASSIGN(cache, hours_cache(folder / "hours", options.rig, options.model));
  }
  MIEN_TRY_ASSIGN(
      const std::vector<HoursRun> runs,
      study_hours(options.request, rig, model, app::terminal_progress("hours"), cache ? &*cache : nullptr));
  app::clear_progress();
  const double most = share_within(runs, kRatioOfMost), all = share_within(runs, kRatioOfAll);
  const std::vector<HoursSummary> summaries = summarise(runs);
  if (options.json) {
    app::Json out = {
        {"model", options.model},          {"rig", rig.name},          {"minutes", options.request.minutes},
        {"motions", options.motions},      {"face", options.face},     {"runs", app::Json::array()},
        {"summaries", app::Json::array()}, {"share_within_1.3", most}, {"share_within_1.6", all}};
    for (const HoursRun& run : runs) out["runs"].push_back(hours_json(run));
    for (const HoursSummary& summary : summaries) out["summaries"].push_back(hours_json(summary));
    app::print_json(out);
    return {};
  }
  fmt::print("{} performances of {:g} minutes on one calibration, model {}\n", runs.size(),
             options.request.minutes, options.model);
  for (const HoursRun& run : runs) print(run);
  print(summaries);
  fmt::print("\nratio at most {} in {:.0f} % of the runs, at most {} in {:.0f} %\n", kRatioOfMost, 100 * most,
             kRatioOfAll, 100 * all);
  return {};
}

}  // namespace

void add_study_hours(app::Commands& commands, app::Command study) {
  auto options = std::make_shared<HoursOptions>();
  const app::Command command = commands.add_under(
      study, "hours", "How accurate a session stays for hours after one calibration, ten minutes at a time",
      "mien study hours --script mixed acted --seeds 2 --minutes 60",
      [options] { return run_study_hours(*options); });
  command.add_option("--model", options->model, "Live model (default: models/live.safetensors)");
  app::add_rig_option(command, options->rig);
  command.add_option(
      "--script", options->scripts,
      "Scripts, as mien perform has them; each is drawn anew every ten minutes (default, without "
      "--motion: mixed reading)");
  command.add_option("--motion", options->motions,
                     "Live Link Face CSVs, or takes with truth, each repeated as long as it takes");
  command.add_option("--face", options->face,
                     "Everyone's face, as mien face takes it (default: a face of the built-in family each)");
  command.add_option("--scenario", options->scenarios, hours_scenario_help()).show_default();
  command.add_option("--seed", options->request.first_seed, "Of the first person and his devices")
      .show_default();
  command
      .add_option("--seeds", options->request.seeds,
                  "People a script or motion, with this seed and those after it")
      .in_range(1, 1000)
      .show_default();
  command.add_option("--minutes", options->request.minutes, "Length of each performance after the prologue")
      .number_between(1.0, 600.0)
      .show_default();
  command.add_option(
      "--held", options->held,
      "Expressions that are held beside the script: browDown_L+browDown_R=0.7@5-15, in minutes");
  app::add_json_flag(command, options->json);
}

}  // namespace mien::lab
