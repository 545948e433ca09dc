#include "app/study/study_hours.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/command.h"
#include "app/json_output.h"
#include "app/study/hours_figures.h"
#include "mien/core/cache_folder.h"
#include "mien/face/profile.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"
#include "mien/study/imu/hours_study.h"
#include "mien/study/imu/hours_summary.h"

namespace mien::app {
namespace {

struct HoursOptions {
  study::HoursRequest request;
  std::vector<std::string> scripts = {"mixed", "reading"};
  std::vector<std::string> held;
  std::string model;
  std::string rig;
  bool perfect = false;
  bool json = false;
};

/// SHAPES=VALUE@BEGIN-END, shapes with a plus between them, times in minutes.
Result<study::HeldExpression> parse_held(const std::string& text) {
  const auto wrong = [&](std::string what) {
    return fail(ErrorCode::bad_usage, std::move(what), "--held " + text,
                "give it as browDown_L+browDown_R=0.7@5-15, in minutes");
  };
  study::HeldExpression held;
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

void print(const study::HoursRun& run) {
  fmt::print("\n{}, seed {}\n{:>7} {:>8} {:>8} {:>8} {:>8} {:>6} {:>8} {:>8} {:>6} {:>8}  {}\n", run.script,
             run.seed, "minute", "MSE", "lab", "known", "frozen", "ratio", "PVE mm", "rotation", "NEES",
             "missing", "largest bias");
  for (const study::HoursPiece& piece : run.pieces) {
    fmt::print(
        "{:7.0f} {:8.4f} {:8.4f} {:8.4f} {:8.4f} {:6.2f} {:8.3f} {:7.2f}° {:6.2f} {:6.1f} %  {} {:+.2f}\n",
        piece.begin_s / 60, piece.mse.device, piece.mse.lab, piece.mse.known, piece.mse.frozen, piece.ratio,
        piece.pve_mm, piece.rotation_rms_deg, piece.nees, 100 * piece.missing,
        face::kShapeNames[piece.worst_shape], piece.worst_bias);
    for (const study::HoursErrors& held : piece.held)
      fmt::print("{:>7} {:8.3f} {:8.3f} {:8.3f} {:8.3f}\n", "held", held.device, held.lab, held.known,
                 held.frozen);
  }
}

void print(const std::vector<study::HoursSummary>& summaries) {
  fmt::print("\n{:<16} {:>4} {:>16} {:>16} {:>8} {:>8} {:>6} {:>6} {:>6} {:>13} {:>10} {:>13}  {}\n",
             "script", "runs", "MSE first, last", "lab", "known", "frozen", "ratio", "<=1.3", "<=1.6",
             "rotation", "NEES", "missing", "largest bias");
  for (const study::HoursSummary& one : summaries)
    fmt::print(
        "{:<16} {:>4} {:7.4f}, {:7.4f} {:7.4f}, {:7.4f} {:8.4f} {:8.4f} {:6.2f} {:4.0f} % {:4.0f} % "
        "{:5.2f}°, {:4.2f}° {:4.2f}, {:4.2f} {:4.1f} %, {:4.1f} %  {} {:+.2f}\n",
        one.script, one.runs, one.first_mse.device, one.last_mse.device, one.first_mse.lab, one.last_mse.lab,
        one.last_mse.known, one.last_mse.frozen, one.worst_ratio, 100 * one.within_most, 100 * one.within_all,
        one.first_rotation_deg, one.worst_rotation_deg, one.least_nees, one.most_nees,
        100 * one.first_missing, 100 * one.worst_missing, face::kShapeNames[one.worst_shape], one.worst_bias);
}

Result<void> run_study_hours(HoursOptions options) {
  MIEN_TRY_ASSIGN(options.rig, path_or(options.rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(options.model, path_or(options.model, "models/live.safetensors"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(options.rig));
  MIEN_TRY_ASSIGN(const model::ModelFile model, model::read_model(options.model));
  for (const std::string& script : options.scripts) {
    MIEN_TRY_ASSIGN(options.request.scripts.emplace_back(), performer::parse_block(script));
  }
  for (const std::string& held : options.held) {
    MIEN_TRY_ASSIGN(options.request.held.emplace_back(), parse_held(held));
  }
  options.request.faults = !options.perfect;
  std::optional<study::HoursCache> cache;
  if (const std::filesystem::path folder = cache_folder(); !folder.empty()) {
    MIEN_TRY_ASSIGN(cache, hours_cache(folder / "hours", options.rig, options.model));
  }
  MIEN_TRY_ASSIGN(
      const std::vector<study::HoursRun> runs,
      study::study_hours(options.request, rig, model, terminal_progress("hours"), cache ? &*cache : nullptr));
  clear_progress();
  const double most = study::share_within(runs, study::kRatioOfMost),
               all = study::share_within(runs, study::kRatioOfAll);
  const std::vector<study::HoursSummary> summaries = study::summarise(runs);
  if (options.json) {
    Json out = {
        {"model", options.model},           {"rig", rig.name},        {"minutes", options.request.minutes},
        {"faults", options.request.faults}, {"runs", Json::array()},  {"summaries", Json::array()},
        {"share_within_1.3", most},         {"share_within_1.6", all}};
    for (const study::HoursRun& run : runs) out["runs"].push_back(hours_json(run));
    for (const study::HoursSummary& summary : summaries) out["summaries"].push_back(hours_json(summary));
    print_json(out);
    return {};
  }
  fmt::print("{} performances of {:g} minutes on one calibration, model {}\n", runs.size(),
             options.request.minutes, options.model);
  for (const study::HoursRun& run : runs) print(run);
  print(summaries);
  fmt::print("\nratio at most {} in {:.0f} % of the runs, at most {} in {:.0f} %\n", study::kRatioOfMost,
             100 * most, study::kRatioOfAll, 100 * all);
  return {};
}

}  // namespace

void add_study_hours(Commands& commands, Command study) {
  auto options = std::make_shared<HoursOptions>();
  const Command command = commands.add_under(
      study, "hours", "How accurate a session stays for hours after one calibration, ten minutes at a time",
      "mien study hours --script mixed acted --seeds 2 --minutes 60",
      [options] { return run_study_hours(*options); });
  command.add_option("--model", options->model, "Live model (default: models/live.safetensors)");
  command.add_option("--rig", options->rig, "Rig file (default: rigs/default.toml)");
  command
      .add_option("--script", options->scripts,
                  "Scripts, as mien perform has them; each is drawn anew every ten minutes")
      .show_default();
  command.add_option("--seed", options->request.first_seed, "Of the first person and his devices")
      .show_default();
  command.add_option("--seeds", options->request.seeds, "People a script, with this seed and those after it")
      .in_range(1, 1000)
      .show_default();
  command.add_option("--minutes", options->request.minutes, "Length of each performance after the prologue")
      .number_between(1.0, 600.0)
      .show_default();
  command.add_option(
      "--held", options->held,
      "Expressions that are held beside the script: browDown_L+browDown_R=0.7@5-15, in minutes");
  command.add_flag("--perfect", options->perfect, "Devices without faults");
  command.add_flag("--json", options->json, "Print one JSON object");
}

}  // namespace mien::app
