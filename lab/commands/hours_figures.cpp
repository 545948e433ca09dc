#include "lab/commands/hours_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "app/private_folder.h"
#include "mien/core/files.h"
#include "mien/core/sha256.h"
#include "mien/face/profile.h"

namespace mien::lab {
namespace {

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
  return piece;
}

}  // namespace

app::Json hours_json(const HoursErrors& errors) {
  return {{"device", errors.device}, {"lab", errors.lab}, {"known", errors.known}, {"frozen", errors.frozen}};
}

app::Json hours_json(const HoursRun& run) {
  app::Json pieces = app::Json::array();
  for (const HoursPiece& piece : run.pieces) {
    pieces.push_back({{"begin_s", piece.begin_s},
                      {"frames", piece.frames},
                      {"mse", hours_json(piece.mse)},
                      {"ratio", piece.ratio},
                      {"pve_mm", piece.pve_mm},
                      {"lab_pve_mm", piece.lab_pve_mm},
                      {"worst_shape", std::string(face::kShapeNames[piece.worst_shape])},
                      {"worst_bias", piece.worst_bias},
                      {"rotation_rms_deg", piece.rotation_rms_deg},
                      {"vertical_rms_deg", piece.vertical_rms_deg},
                      {"sensor_rms_deg", piece.sensor_rms_deg},
                      {"frozen_sensor_rms_deg", piece.frozen_sensor_rms_deg},
                      {"nees", piece.nees},
                      {"missing", piece.missing},
                      {"held", app::Json::array()}});
    for (const HoursErrors& held : piece.held) pieces.back()["held"].push_back(hours_json(held));
  }
  return {{"script", run.script}, {"scenario", run.scenario},       {"seed", run.seed},
          {"sensor", run.sensor}, {"event_end_s", run.event_end_s}, {"pieces", pieces}};
}

app::Json hours_json(const HoursSummary& summary) {
  return {{"script", summary.script},
          {"scenario", summary.scenario},
          {"runs", summary.runs},
          {"first_mse", hours_json(summary.first_mse)},
          {"last_mse", hours_json(summary.last_mse)},
          {"worst_ratio", summary.worst_ratio},
          {"share_within_1.3", summary.within_most},
          {"share_within_1.6", summary.within_all},
          {"first_rotation_rms_deg", summary.first_rotation_deg},
          {"worst_rotation_rms_deg", summary.worst_rotation_deg},
          {"least_nees", summary.least_nees},
          {"most_nees", summary.most_nees},
          {"first_missing", summary.first_missing},
          {"worst_missing", summary.worst_missing},
          {"worst_shape", std::string(face::kShapeNames[summary.worst_shape])},
          {"worst_bias", summary.worst_bias},
          {"later_sensor_rms_deg", summary.sensor_deg},
          {"later_frozen_sensor_rms_deg", summary.frozen_sensor_deg}};
}

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
                      return write_file(path_of(key), app::json_text(hours_json(run)));
                    }};
}

}  // namespace mien::lab
