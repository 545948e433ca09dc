#include "lab/commands/studies.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/chosen_face.h"
#include "app/json_output.h"
#include "app/performance.h"
#include "app/seed_option.h"
#include "lab/commands/output.h"
#include "lab/headset/headset_study.h"
#include "mien/face/profile.h"
#include "mien/headset/views_file.h"
#include "mien/sensor/rig.h"

namespace mien::lab {
namespace {

struct StudyHeadsetOptions {
  HeadsetStudyRequest request;
  Output to;
  std::string rig, model, motion, face;
  std::string precision{model::precision_name(headset::kHeadsetPrecision)};
  int wearers = 0;     // 0: the default.
  double minutes = 0;  // Of a session of hours; 0: the conditions instead.
};

constexpr std::array kParts = {"upper", "lower", "gaze"};

app::Json confidence_json(const HeadsetScore& score) {
  app::Json json;
  for (std::size_t i = 0; i < kParts.size(); ++i)
    json[kParts[i]] = {{"ece", score.reliability[i].expected_error()}, {"auc", score.roc[i].area()}};
  return json;
}

/// The ratio to a score's MSE is to that of the first score.
Columns<HeadsetScore> score_columns(double first_mse) {
  using Score = HeadsetScore;
  Columns<Score> columns = {
      {"condition", "", "{}", [](const Score& s) { return std::string(condition_name(s.condition)); }},
      {"mse", "MSE", "{:.5f}", &Score::mse},
      {"", "/ mean", "{:.3f}", [](const Score& s) { return s.mse / s.mean_pose_mse; }},
      {"", "/ worn", "{:.3f}", [first_mse](const Score& s) { return s.mse / first_mse; }},
      {"mean_pose_mse", "", "", &Score::mean_pose_mse},
      {"left_eye_mse", "", "", &Score::left_eye_mse},
      {"right_eye_mse", "", "", &Score::right_eye_mse},
      {"mouth_mse", "", "", &Score::mouth_mse},
      {"pve_mm", "PVE mm", "{:.3f}", &Score::pve_mm},
      {"jitter_ratio", "jitter", "{:.2f}", &Score::jitter_ratio},
      {"blink_f1", "blink", "{:.3f}", [](const Score& s) { return or_null(s.blink_f1); }},
      {"closed_f1", "closed", "{:.3f}", [](const Score& s) { return or_null(s.closed_f1); }},
      {"wink_f1", "wink", "{:.3f}", [](const Score& s) { return or_null(s.wink_f1); }},
      {"lip_gap_f1", "lips", "{:.3f}", [](const Score& s) { return or_null(s.lips_f1); }},
      {"gaze_deg", "", "",
       [](const Score& s) {
         return app::Json{{"median", s.gaze_median_deg}, {"p90", s.gaze_p90_deg}};
       }},
      {"", "gaze, °", "{:.2f}", &Score::gaze_median_deg},
      {"", "p90", "{:.2f}", &Score::gaze_p90_deg},
      {"confidence", "", "", confidence_json}};
  for (std::size_t i = 0; i < kParts.size(); ++i)
    columns.push_back({"", fmt::format("ECE {}", kParts[i]), "{:.3f}",
                       [i](const Score& s) { return s.reliability[i].expected_error(); }});
  for (std::size_t i = 0; i < kParts.size(); ++i)
    columns.push_back(
        {"", fmt::format("AUC {}", kParts[i]), "{:.3f}", [i](const Score& s) { return s.roc[i].area(); }});
  return columns;
}

/// The confidence of frames as worn and of those in which something hides the face, as one.
HeadsetScore worn_and_hidden(const std::vector<HeadsetScore>& scores) {
  const auto of = [&](HeadsetCondition condition) -> const HeadsetScore& {
    return *std::ranges::find(scores, condition, &HeadsetScore::condition);
  };
  HeadsetScore both = of(HeadsetCondition::as_worn);
  const HeadsetScore& hidden = of(HeadsetCondition::hidden);
  for (std::size_t i = 0; i < kParts.size(); ++i) {
    both.reliability[i].add(hidden.reliability[i]);
    both.roc[i].add(hidden.roc[i]);
  }
  return both;
}

const Columns<HeadsetHoursPiece>& hours_columns() {
  using Piece = HeadsetHoursPiece;
  static const Columns<Piece> columns = {
      {"begin_s", "minute", "{:.0f}", &Piece::begin_s, 1.0 / 60},
      {"mse", "MSE", "{:.4f}", &Piece::mse},
      {"no_slip_mse", "no slip", "{:.4f}", &Piece::still_mse},
      {"recentred_mse", "re-centred", "{:.4f}", &Piece::recentred_mse},
      {"mean_pose_mse", "mean pose", "{:.4f}", &Piece::mean_pose_mse},
      {"ratio", "ratio", "{:.2f}", &Piece::ratio},
      {"recentred_ratio", "re-centred ratio", "{:.2f}", &Piece::recentred_ratio},
      {"worst_shape", "largest bias", "{}",
       [](const Piece& piece) { return face::kShapeNames[piece.worst_shape]; }},
      {"worst_bias", "by", "{:+.2f}", &Piece::worst_bias}};
  return columns;
}

Result<void> run_headset_hours(const StudyHeadsetOptions& options, const sensor::Rig& rig,
                               const std::shared_ptr<const headset::HeadsetModel>& model,
                               const std::vector<float>& mean_answer) {
  HeadsetHoursRequest request{
      .minutes = options.minutes, .seconds = options.request.seconds, .seed = options.request.seed};
  if (options.wearers > 0) request.wearers = options.wearers;
  MIEN_TRY_ASSIGN(const auto wearers,
                  study_headset_hours(request, rig, model, mean_answer, app::terminal_progress("headset")));
  measure::Report report(fmt::format("A headset's accuracy over {:g} minutes", options.minutes),
                         fmt::format("{} virtual wearers, seed {}", wearers.size(), request.seed));
  app::Json pieces = app::Json::array();
  for (std::size_t w = 0; w < wearers.size(); ++w) {
    report.table(table_of(fmt::format("wearer {}", w + 1), wearers[w], hours_columns()));
    pieces.push_back(json_of(wearers[w], hours_columns()));
  }
  return put_out(options.to, report, {{"seed", request.seed}, {"wearers", std::move(pieces)}});
}

Result<void> run_study_headset(const StudyHeadsetOptions& options) {
  MIEN_TRY_ASSIGN(const std::filesystem::path file, app::path_or(options.rig, "rigs/headset.toml"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(file));
  MIEN_TRY_ASSIGN(const std::filesystem::path model_path,
                  app::path_or(options.model, "models/headset.safetensors"));
  MIEN_TRY_ASSIGN(const headset::ViewsFile views, headset::read_views_file(model_path));
  MIEN_TRY_ASSIGN(const auto model, headset::HeadsetModel::create(
                                        views, model::precision_from_name(options.precision).value()));
  if (options.minutes > 0) return run_headset_hours(options, rig, model, views.mean_answer);
  HeadsetStudyRequest request = options.request;
  if (options.wearers > 0) request.wearers = options.wearers;
  if (!options.motion.empty()) {
    MIEN_TRY_ASSIGN(app::Performance performance, app::load_performance(options.motion));
    request.motion = std::move(performance.motion);
  }
  if (!options.face.empty()) {
    MIEN_TRY_ASSIGN(request.face, app::chosen_face(options.face, app::face_progress(options.face)));
  }
  MIEN_TRY_ASSIGN(const std::vector<HeadsetScore> scores,
                  study_headset(request, rig, model, views.mean_answer, app::terminal_progress("headset")));
  const HeadsetScore both = worn_and_hidden(scores);
  const Columns<HeadsetScore> columns = score_columns(scores.front().mse);
  measure::Report report(
      "A headset's cameras, wearers unseen in training",
      fmt::format("{} virtual wearers of {:g} s, seed {}", request.wearers, request.seconds, request.seed));
  report.table(table_of("By condition", scores, columns));
  std::vector<measure::KeyFigure> confidence;
  for (std::size_t i = 0; i < kParts.size(); ++i)
    confidence.push_back({fmt::format("Confidence of {}, as worn and hidden together", kParts[i]),
                          fmt::format("ECE {:.3f}", both.reliability[i].expected_error()),
                          fmt::format("AUC {:.3f}", both.roc[i].area())});
  report.key_figures(confidence);
  return put_out(options.to, report,
                 {{"wearers", request.wearers},
                  {"seconds", request.seconds},
                  {"seed", request.seed},
                  {"conditions", json_of(scores, columns)},
                  {"confidence_worn_and_hidden", confidence_json(both)}});
}

}  // namespace

void add_study_headset(app::Commands& commands, app::Command study) {
  auto options = std::make_shared<StudyHeadsetOptions>();
  const app::Command command = commands.add_under(
      study, "headset",
      "How well a headset's cameras tell the face of wearers whom nothing learnt from, as worn, put on anew, "
      "with slow or lost cameras and hidden",
      "mien study headset --wearers 30 --seconds 8", [options] { return run_study_headset(*options); });
  command.add_option("--rig", options->rig, "Rig file (default: rigs/headset.toml)");
  command.add_option("--model", options->model, "Model (default: models/headset.safetensors)");
  command.add_option("--precision", options->precision, "What its layers multiply in: fp32, bf16 or int8")
      .one_of({"fp32", "bf16", "int8"})
      .show_default();
  command.add_option("--wearers", options->wearers, "Virtual wearers (default: 30, with --minutes 2)")
      .in_range(1, 1000);
  command.add_option("--seconds", options->request.seconds, "Of motion a wearer")
      .in_range(1.0, 3600.0)
      .show_default();
  command.add_option(
      "--motion", options->motion,
      "What all of them perform: a Live Link Face CSV, or a take whose truth; else a script each");
  command.add_option("--face", options->face, "The face that all of them have; else the built-in family");
  const app::Option minutes =
      command
          .add_option("--minutes", options->minutes,
                      "How accurate it stays instead, for so long after one neutral: --seconds are seen of "
                      "each ten minutes, while the headset slips, beside one that does not and one that is "
                      "re-centred")
          .in_range(10.0, 180.0);
  for (const char* name : {"--motion", "--face"}) minutes.excludes(command.option(name));
  app::add_json_flag(command, options->to.json);
  app::add_seed_option(command, options->request.seed, "Of the wearers and their headsets");
}

}  // namespace mien::lab
