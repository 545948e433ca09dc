#include "lab/commands/studies.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/chosen_face.h"
#include "app/command.h"
#include "app/json_output.h"
#include "app/performance.h"
#include "app/private_folder.h"
#include "lab/commands/output.h"
#include "lab/imu/hours_study.h"
#include "mien/core/files.h"
#include "mien/core/sha256.h"
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
  Output to;
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

HoursErrors hours_errors_of(const app::Json& json) {
  return {.device = json.at("device"),
          .lab = json.at("lab"),
          .known = json.at("known"),
          .frozen = json.at("frozen")};
}

HoursPiece hours_piece_of(const app::Json& json) {
  HoursPiece piece{.begin_s = json.at("begin_s"),
                   .frames = json.at("frames"),
                   .mse = hours_errors_of(json.at("mse")),
                   .ratio = json.at("ratio"),
                   .pve_mm = json.at("pve_mm"),
                   .lab_pve_mm = json.at("lab_pve_mm"),
                   .worst_shape = face::shape_index(json.at("worst_shape").get<std::string>()),
                   .worst_bias = json.at("worst_bias"),
                   .rotation_rms_deg = json.at("rotation_rms_deg"),
                   .vertical_rms_deg = json.at("vertical_rms_deg"),
                   .sensor_rms_deg = json.at("sensor_rms_deg"),
                   .frozen_sensor_rms_deg = json.at("frozen_sensor_rms_deg"),
                   .nees = json.at("nees"),
                   .missing = json.at("missing")};
  for (const app::Json& held : json.at("held")) piece.held.push_back(hours_errors_of(held));
  for (const app::Json& released : json.at("released")) piece.released.push_back(hours_errors_of(released));
  return piece;
}

app::Json errors_json(const HoursErrors& errors) {
  return {{"device", errors.device}, {"lab", errors.lab}, {"known", errors.known}, {"frozen", errors.frozen}};
}

app::Json errors_json(const std::vector<HoursErrors>& all) {
  app::Json out = app::Json::array();
  for (const HoursErrors& errors : all) out.push_back(errors_json(errors));
  return out;
}

/// `sensor`: something happens to one.
Columns<HoursPiece> piece_columns(bool sensor) {
  using Piece = HoursPiece;
  return {{"begin_s", "minute", "{:.0f}", &Piece::begin_s, 1.0 / 60},
          {"frames", "", "", &Piece::frames},
          {"mse", "", "", [](const Piece& piece) { return errors_json(piece.mse); }},
          {"", "MSE", "{:.4f}", [](const Piece& piece) { return piece.mse.device; }},
          {"", "lab", "{:.4f}", [](const Piece& piece) { return piece.mse.lab; }},
          {"", "known", "{:.4f}", [](const Piece& piece) { return piece.mse.known; }},
          {"", "frozen", "{:.4f}", [](const Piece& piece) { return piece.mse.frozen; }},
          {"ratio", "ratio", "{:.2f}", &Piece::ratio},
          {"pve_mm", "PVE mm", "{:.3f}", &Piece::pve_mm},
          {"lab_pve_mm", "", "", &Piece::lab_pve_mm},
          {"worst_shape", "", "", [](const Piece& piece) { return face::kShapeNames[piece.worst_shape]; }},
          {"worst_bias", "", "", &Piece::worst_bias},
          {"rotation_rms_deg", "rotation, °", "{:.2f}", &Piece::rotation_rms_deg},
          {"vertical_rms_deg", "vertical, °", "{:.2f}", &Piece::vertical_rms_deg},
          {"sensor_rms_deg", "sensor, °", sensor ? "{:.2f}" : "", &Piece::sensor_rms_deg},
          {"frozen_sensor_rms_deg", "frozen, °", sensor ? "{:.1f}" : "", &Piece::frozen_sensor_rms_deg},
          {"nees", "NEES", "{:.2f}", &Piece::nees},
          {"missing", "missing, %", "{:.1f}", &Piece::missing, 100},
          {"", "largest bias", "{}",
           [](const Piece& piece) {
             return fmt::format("{} {:+.2f}", face::kShapeNames[piece.worst_shape], piece.worst_bias);
           }},
          {"held", "", "", [](const Piece& piece) { return errors_json(piece.held); }},
          {"released", "", "", [](const Piece& piece) { return errors_json(piece.released); }}};
}

const Columns<HoursRun>& run_columns() {
  static const Columns<HoursRun> columns = {
      {"script", "", "", &HoursRun::script},
      {"scenario", "", "", &HoursRun::scenario},
      {"seed", "", "", &HoursRun::seed},
      {"sensor", "", "", &HoursRun::sensor},
      {"event_end_s", "", "", &HoursRun::event_end_s},
      {"pieces", "", "", [](const HoursRun& run) { return json_of(run.pieces, piece_columns(false)); }}};
  return columns;
}

measure::Table run_table(const HoursRun& run) {
  measure::Table table = table_of(fmt::format("{}, {}, seed {}{}", run.script, run.scenario, run.seed,
                                              run.sensor.empty() ? "" : ", " + run.sensor),
                                  run.pieces, piece_columns(!run.sensor.empty()));
  std::ptrdiff_t row = 0;
  const auto add = [&](std::string_view what, const std::vector<HoursErrors>& all) {
    for (const HoursErrors& weights : all)
      table.rows.insert(
          table.rows.begin() + row++,
          {std::string(what), fmt::format("{:.3f}", weights.device), fmt::format("{:.3f}", weights.lab),
           fmt::format("{:.3f}", weights.known), fmt::format("{:.3f}", weights.frozen)});
  };
  for (const HoursPiece& piece : run.pieces) {
    ++row;
    add("held", piece.held);
    add("released", piece.released);
  }
  return table;
}

const Columns<HoursSummary>& summary_columns() {
  using Summary = HoursSummary;
  static const Columns<Summary> columns = {
      {"script", "script", "{}", &Summary::script},
      {"scenario", "scenario", "{}", &Summary::scenario},
      {"runs", "runs", "{}", &Summary::runs},
      {"first_mse", "", "", [](const Summary& one) { return errors_json(one.first_mse); }},
      {"last_mse", "", "", [](const Summary& one) { return errors_json(one.last_mse); }},
      {"", "MSE first", "{:.4f}", [](const Summary& one) { return one.first_mse.device; }},
      {"", "last", "{:.4f}", [](const Summary& one) { return one.last_mse.device; }},
      {"", "lab first", "{:.4f}", [](const Summary& one) { return one.first_mse.lab; }},
      {"", "last", "{:.4f}", [](const Summary& one) { return one.last_mse.lab; }},
      {"", "known", "{:.4f}", [](const Summary& one) { return one.last_mse.known; }},
      {"", "frozen", "{:.4f}", [](const Summary& one) { return one.last_mse.frozen; }},
      {"worst_ratio", "ratio", "{:.2f}", &Summary::worst_ratio},
      {"share_within_1.3", "<=1.3, %", "{:.0f}", &Summary::within_most, 100},
      {"share_within_1.6", "<=1.6, %", "{:.0f}", &Summary::within_all, 100},
      {"first_rotation_rms_deg", "rotation, °", "{:.2f}", &Summary::first_rotation_deg},
      {"worst_rotation_rms_deg", "worst", "{:.2f}", &Summary::worst_rotation_deg},
      {"least_nees", "NEES least", "{:.2f}", &Summary::least_nees},
      {"most_nees", "most", "{:.2f}", &Summary::most_nees},
      {"first_missing", "missing, %", "{:.1f}", &Summary::first_missing, 100},
      {"worst_missing", "worst", "{:.1f}", &Summary::worst_missing, 100},
      {"worst_shape", "largest bias", "{}",
       [](const Summary& one) { return face::kShapeNames[one.worst_shape]; }},
      {"worst_bias", "by", "{:+.2f}", &Summary::worst_bias},
      {"later_sensor_rms_deg", "sensor, °", "{:.2f}", &Summary::sensor_deg},
      {"later_frozen_sensor_rms_deg", "frozen, °", "{:.1f}", &Summary::frozen_sensor_deg}};
  return columns;
}

/// Errors: malformed.
Result<HoursRun> parse_hours_run(std::string_view text, const std::string& where) {
  HoursRun run;
  try {
    const app::Json json = app::Json::parse(text);
    run.script = json.at("script");
    run.scenario = json.at("scenario");
    run.seed = json.at("seed");
    run.sensor = json.at("sensor");
    run.event_end_s = json.at("event_end_s");
    for (const app::Json& piece : json.at("pieces")) run.pieces.push_back(hours_piece_of(piece));
  } catch (const app::Json::exception& error) {
    return fail(ErrorCode::malformed, error.what(), where);
  }
  if (run.pieces.empty() || std::ranges::any_of(run.pieces, [](const HoursPiece& piece) {
        return piece.worst_shape >= face::kShapeCount;
      }))
    return fail(ErrorCode::malformed, "these are no figures of a run", where);
  return run;
}

/// Keeps each run's figures as a file of JSON in `folder`, which is made where it is not. Its name is a hash
/// of the run's key, the rig's and the model's bytes and this program's own. A file that cannot be read is
/// made anew. Errors: those of reading the rig, the model and the program; io (the folder).
Result<HoursCache> hours_cache(const std::filesystem::path& folder, const std::filesystem::path& rig,
                               const std::filesystem::path& model) {
  MIEN_TRY(app::make_private_folders(folder));
  MIEN_TRY_ASSIGN(const std::filesystem::path program, running_program());
  std::string basis;
  for (const std::filesystem::path& path : {program, rig, model}) {
    MIEN_TRY_ASSIGN(const std::vector<std::byte> bytes, read_file(path));
    Sha256 hash;
    hash.add(bytes);
    basis += hash.hex() + "\n";
  }
  const auto path_of = [folder, basis](const std::string& key) {
    Sha256 hash;
    const std::string all = basis + key;
    hash.add(std::as_bytes(std::span(all)));
    return folder / (hash.hex().substr(0, 24) + ".json");
  };
  return HoursCache{.find = [path_of](const std::string& key) -> std::optional<HoursRun> {
                      const Result<std::string> text = read_text(path_of(key));
                      if (!text) return std::nullopt;
                      Result<HoursRun> run = parse_hours_run(*text, path_of(key).string());
                      if (!run) return std::nullopt;
                      return std::move(*run);
                    },
                    .keep = [path_of](const std::string& key, const HoursRun& run) -> Result<void> {
                      return write_file(path_of(key), app::json_text(json_of(run, run_columns())));
                    }};
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
  const double most = share_within(runs, kRatioOfMost), all = share_within(runs, kRatioOfAll);
  const std::vector<HoursSummary> summaries = summarise(runs);
  measure::Report report(
      fmt::format("{} performances of {:g} minutes on one calibration", runs.size(), options.request.minutes),
      "model " + options.model);
  for (const HoursRun& run : runs) report.table(run_table(run));
  report.table(table_of("By script and scenario", summaries, summary_columns()));
  report.text(fmt::format("Ratio at most {} in {:.0f} % of the runs, at most {} in {:.0f} %.", kRatioOfMost,
                          100 * most, kRatioOfAll, 100 * all));
  return put_out(options.to, report,
                 {{"model", options.model},
                  {"rig", rig.name},
                  {"minutes", options.request.minutes},
                  {"motions", options.motions},
                  {"face", options.face},
                  {"runs", json_of(runs, run_columns())},
                  {"summaries", json_of(summaries, summary_columns())},
                  {"share_within_1.3", most},
                  {"share_within_1.6", all}});
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
  app::add_json_flag(command, options->to.json);
}

}  // namespace mien::lab
