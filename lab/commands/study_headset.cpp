#include "lab/commands/study_headset.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/chosen_face.h"
#include "app/json_output.h"
#include "app/performance.h"
#include "app/seed_option.h"
#include "lab/headset/contact_sheet.h"
#include "lab/headset/headset_hours.h"
#include "lab/headset/headset_study.h"
#include "mien/face/profile.h"
#include "mien/headset/views_file.h"
#include "mien/render/lettering.h"
#include "mien/sensor/rig.h"

namespace mien::lab {
namespace {

struct StudyHeadsetOptions {
  HeadsetStudyRequest request;
  ContactSheetRequest sheet;
  std::string out, rig, model, motion, face;
  std::string precision{model::precision_name(headset::kHeadsetPrecision)};
  int wearers = 0;     // 0: the default.
  double minutes = 0;  // Of a session of hours; 0: the conditions instead.
  bool json = false;
};

Result<void> write_sheet(const StudyHeadsetOptions& options, const sensor::Rig& rig) {
  ContactSheetRequest request = options.sheet;
  request.seed = options.request.seed;
  if (options.wearers > 0) request.wearers = options.wearers;
  if (std::filesystem::exists(render::kFontFile)) request.font = render::kFontFile;
  MIEN_TRY_ASSIGN(const render::Image sheet,
                  headset_contact_sheet(request, rig, app::terminal_progress("headset")));
  app::clear_progress();
  MIEN_TRY(render::write_png(options.out, sheet));
  fmt::print("{}: {} x {} pixels\n", options.out, sheet.width, sheet.height);
  return {};
}

app::Json or_null(const std::optional<double>& value) {
  return value ? app::Json(*value) : app::Json();
}
std::string or_dash(const std::optional<double>& value) {
  return value ? fmt::format("{:.3f}", *value) : "-";
}

constexpr std::array kParts = {"upper", "lower", "gaze"};

app::Json confidence_json(const HeadsetScore& score) {
  app::Json json;
  for (std::size_t i = 0; i < kParts.size(); ++i)
    json[kParts[i]] = {{"ece", score.reliability[i].expected_error()}, {"auc", score.roc[i].area()}};
  return json;
}

app::Json score_json(const HeadsetScore& score) {
  app::Json row = {{"condition", std::string(condition_name(score.condition))},
                   {"mse", score.mse},
                   {"mean_pose_mse", score.mean_pose_mse},
                   {"left_eye_mse", score.left_eye_mse},
                   {"right_eye_mse", score.right_eye_mse},
                   {"mouth_mse", score.mouth_mse},
                   {"pve_mm", score.pve_mm},
                   {"jitter_ratio", score.jitter_ratio},
                   {"blink_f1", or_null(score.blink_f1)},
                   {"closed_f1", or_null(score.closed_f1)},
                   {"wink_f1", or_null(score.wink_f1)},
                   {"lip_gap_f1", or_null(score.lips_f1)},
                   {"gaze_deg", {{"median", score.gaze_median_deg}, {"p90", score.gaze_p90_deg}}}};
  row["confidence"] = confidence_json(score);
  return row;
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

void print_headset_scores(const std::vector<HeadsetScore>& scores) {
  fmt::print("{:<20} {:>8} {:>7} {:>7} {:>7} {:>6} {:>6} {:>6} {:>6} {:>6} {:>12} {:>17} {:>17}\n", "", "MSE",
             "/ mean", "/ worn", "PVE mm", "jitter", "blink", "closed", "wink", "lips", "gaze deg", "ECE",
             "AUC");
  for (const HeadsetScore& score : scores)
    fmt::print(
        "{:<20} {:>8.5f} {:>7.3f} {:>7.3f} {:>7.3f} {:>6.2f} {:>6} {:>6} {:>6} {:>6} {:>5.2f} "
        "{:>6.2f} {:>5.3f} "
        "{:>5.3f} "
        "{:>5.3f} {:>5.3f} {:>5.3f} {:>5.3f}\n",
        condition_name(score.condition), score.mse, score.mse / score.mean_pose_mse,
        score.mse / scores.front().mse, score.pve_mm, score.jitter_ratio, or_dash(score.blink_f1),
        or_dash(score.closed_f1), or_dash(score.wink_f1), or_dash(score.lips_f1), score.gaze_median_deg,
        score.gaze_p90_deg, score.reliability[0].expected_error(), score.reliability[1].expected_error(),
        score.reliability[2].expected_error(), score.roc[0].area(), score.roc[1].area(), score.roc[2].area());
  const HeadsetScore both = worn_and_hidden(scores);
  fmt::print("confidence, as worn and hidden together:");
  for (std::size_t i = 0; i < kParts.size(); ++i)
    fmt::print("{} {} ECE {:.3f}, AUC {:.3f}", i == 0 ? "" : ";", kParts[i],
               both.reliability[i].expected_error(), both.roc[i].area());
  fmt::print("\n");
}

void print_headset_hours(const std::vector<std::vector<HeadsetHoursPiece>>& wearers) {
  for (std::size_t w = 0; w < wearers.size(); ++w) {
    fmt::print("{}wearer {}\n{:>7} {:>8} {:>8} {:>10} {:>9} {:>6} {:>16}  {}\n", w > 0 ? "\n" : "", w + 1,
               "minute", "MSE", "no slip", "re-centred", "mean pose", "ratio", "re-centred ratio",
               "largest bias");
    for (const HeadsetHoursPiece& piece : wearers[w])
      fmt::print("{:7.0f} {:8.4f} {:8.4f} {:10.4f} {:9.4f} {:6.2f} {:16.2f}  {} {:+.2f}\n",
                 piece.begin_s / 60, piece.mse, piece.still_mse, piece.recentred_mse, piece.mean_pose_mse,
                 piece.ratio, piece.recentred_ratio, face::kShapeNames[piece.worst_shape], piece.worst_bias);
  }
}

app::Json headset_hours_json(const std::vector<std::vector<HeadsetHoursPiece>>& wearers) {
  app::Json out = app::Json::array();
  for (const auto& pieces : wearers) {
    app::Json& wearer = out.emplace_back(app::Json::array());
    for (const HeadsetHoursPiece& piece : pieces)
      wearer.push_back({{"begin_s", piece.begin_s},
                        {"mse", piece.mse},
                        {"no_slip_mse", piece.still_mse},
                        {"recentred_mse", piece.recentred_mse},
                        {"mean_pose_mse", piece.mean_pose_mse},
                        {"ratio", piece.ratio},
                        {"recentred_ratio", piece.recentred_ratio},
                        {"worst_shape", face::kShapeNames[piece.worst_shape]},
                        {"worst_bias", piece.worst_bias}});
  }
  return out;
}

Result<void> run_headset_hours(const StudyHeadsetOptions& options, const sensor::Rig& rig,
                               const std::shared_ptr<const headset::HeadsetModel>& model,
                               const std::vector<float>& mean_answer) {
  HeadsetHoursRequest request{
      .minutes = options.minutes, .seconds = options.request.seconds, .seed = options.request.seed};
  if (options.wearers > 0) request.wearers = options.wearers;
  MIEN_TRY_ASSIGN(const auto wearers,
                  study_headset_hours(request, rig, model, mean_answer, app::terminal_progress("headset")));
  app::clear_progress();
  if (!options.json)
    print_headset_hours(wearers);
  else
    fmt::print("{}\n", app::Json{{"seed", request.seed}, {"wearers", headset_hours_json(wearers)}}.dump(2));
  return {};
}

Result<void> run_study_headset(const StudyHeadsetOptions& options) {
  MIEN_TRY_ASSIGN(const std::filesystem::path file, app::path_or(options.rig, "rigs/headset.toml"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(file));
  if (!options.out.empty()) return write_sheet(options, rig);
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
  app::clear_progress();
  if (!options.json) {
    print_headset_scores(scores);
    return {};
  }
  app::Json out = {{"wearers", request.wearers}, {"seconds", request.seconds}, {"seed", request.seed}};
  for (const HeadsetScore& score : scores) out["conditions"].push_back(score_json(score));
  out["confidence_worn_and_hidden"] = confidence_json(worn_and_hidden(scores));
  fmt::print("{}\n", out.dump(2));
  return {};
}

}  // namespace

void add_study_headset(app::Commands& commands, app::Command study) {
  auto options = std::make_shared<StudyHeadsetOptions>();
  const app::Command command = commands.add_under(
      study, "headset",
      "How well a headset's cameras tell the face of wearers whom nothing learnt from, as worn, put on anew, "
      "with slow or lost cameras and hidden; or a sheet of what they see",
      "mien study headset --wearers 30 --seconds 8", [options] { return run_study_headset(*options); });
  command.add_option("--sheet", options->out, "Write a PNG of wearers and expressions instead");
  command.add_option("--rig", options->rig, "Rig file (default: rigs/headset.toml)");
  command.add_option("--model", options->model, "Model (default: models/headset.safetensors)");
  command.add_option("--precision", options->precision, "What its layers multiply in: fp32, bf16 or int8")
      .one_of({"fp32", "bf16", "int8"})
      .show_default();
  command
      .add_option("--wearers", options->wearers,
                  "Virtual wearers (default: 30, with --minutes 2); of a sheet, a row each (default: 6)")
      .in_range(1, 1000);
  command.add_option("--seconds", options->request.seconds, "Of motion a wearer")
      .in_range(1.0, 3600.0)
      .show_default();
  command.add_option(
      "--motion", options->motion,
      "What all of them perform: a Live Link Face CSV, or a take whose truth; else a script each");
  command.add_option("--face", options->face, "The face that all of them have; else the built-in family");
  command.add_flag("--failures", options->sheet.failures,
                   "Of a sheet: a row for each thing that hides a face, instead of expressions");
  command.add_option("--side", options->sheet.side, "Of a sheet: pixels of a view either way")
      .in_range(16, 480)
      .show_default();
  const app::Option minutes =
      command
          .add_option("--minutes", options->minutes,
                      "How accurate it stays instead, for so long after one neutral: --seconds are seen of "
                      "each ten minutes, while the headset slips, beside one that does not and one that is "
                      "re-centred")
          .in_range(10.0, 180.0);
  for (const char* name : {"--sheet", "--motion", "--face", "--failures", "--side"})
    minutes.excludes(command.option(name));
  app::add_json_flag(command, options->json);
  app::add_seed_option(command, options->request.seed, "Of the wearers and their headsets");
}

}  // namespace mien::lab
