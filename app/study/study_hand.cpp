#include "app/study/study_hand.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "app/json_output.h"
#include "app/media_helper.h"
#include "app/seed_option.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/core/files.h"
#include "mien/headset/views_file.h"
#include "mien/render/lettering.h"
#include "mien/study/headset/hand_sheet.h"
#include "mien/study/headset/hand_study.h"

namespace mien::app {
namespace {

struct StudyHandOptions {
  study::HandStudyRequest request;
  std::string rig, model, sheet, film;
  bool json = false;
};

Result<study::HandScene> read_scene(const StudyHandOptions& options) {
  study::HandScene scene;
  MIEN_TRY_ASSIGN(const std::filesystem::path rig, path_or(options.rig, "rigs/headset.toml"));
  MIEN_TRY_ASSIGN(scene.rig, sensor::read_rig(rig));
  MIEN_TRY_ASSIGN(const std::filesystem::path model, path_or(options.model, "models/headset.safetensors"));
  MIEN_TRY_ASSIGN(const headset::ViewsFile views, headset::read_views_file(model));
  MIEN_TRY_ASSIGN(scene.model, headset::HeadsetModel::create(views));
  MIEN_TRY_ASSIGN(const std::filesystem::path network, find_resource("models/speech.safetensors"));
  MIEN_TRY_ASSIGN(scene.network, speech::read_speech_network(network));
  return scene;
}

/// Empty where it is not installed: then there are no headings.
std::string heading_font() {
  return std::filesystem::exists(render::kFontFile) ? std::string(render::kFontFile) : std::string();
}

Result<void> write_sheet(const StudyHandOptions& options, const study::HandPerson& person) {
  MIEN_TRY_ASSIGN(const render::Image sheet, study::hand_sheet(person, options.request.hand_s,
                                                               builtin_face::make_builtin(), heading_font()));
  return render::write_png(options.sheet, sheet);
}

/// Every second moment, with what is said.
Result<void> write_film(const StudyHandOptions& options, const study::HandPerson& person) {
  const face::Face face = builtin_face::make_builtin();
  MIEN_TRY_ASSIGN(study::HandPainter painter, study::HandPainter::create(face, heading_font()));
  std::optional<FilmWriter> film;
  for (std::size_t i = 0; i < person.moments.size(); i += 2) {
    const render::Image frame = painter.across(person.moments[i]);
    if (!film) {
      MIEN_TRY_ASSIGN(
          film, FilmWriter::start(options.film, frame.width, frame.height, kFrameRateHz / 2, person.sound));
    }
    MIEN_TRY(film->add_frame(frame));
  }
  return film->finish();
}

Json row_json(const study::HandPerson& person, const study::HandRow& row, bool audio) {
  return {{"seed", person.seed},
          {"voice", person.voice},
          {"audio", audio},
          {"notice_s", row.over.notice_s},
          {"jerk_ratio", row.over.jerk_ratio},
          {"mouth_change", row.mouth_change},
          {"last_change", row.last_change},
          {"recover_s", row.over.recover_s},
          {"mouth_mm", row.over.mouth_mm}};
}

Result<void> run_study_hand(const StudyHandOptions& options) {
  if (!options.sheet.empty()) MIEN_TRY(check_output(options.sheet, {".png"}));
  if (!options.film.empty()) MIEN_TRY(check_output(options.film, {".mp4"}));
  MIEN_TRY_ASSIGN(const study::HandScene scene, read_scene(options));
  MIEN_TRY_ASSIGN(const auto people,
                  study::study_hand(options.request, scene, speaker_by_helper(), terminal_progress("hand")));
  clear_progress();
  if (!options.sheet.empty()) MIEN_TRY(write_sheet(options, people.front()));
  if (!options.film.empty()) MIEN_TRY(write_film(options, people.front()));
  if (options.json) {
    Json rows = Json::array();
    for (const study::HandPerson& person : people)
      for (const bool audio : {false, true})
        rows.push_back(row_json(person, audio ? person.heard : person.held, audio));
    print_json({{"rig", scene.rig.name}, {"hand_s", options.request.hand_s}, {"rows", std::move(rows)}});
    return {};
  }
  fmt::print("{}: a hand is before the mouth for {} s in the middle of a sentence\n\n", scene.rig.name,
             options.request.hand_s);
  fmt::print(
      "| seed | voice | microphone | notice ms | jerk | mouth change | last | recover ms | mouth mm |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|\n");
  for (const study::HandPerson& person : people)
    for (const bool audio : {false, true}) {
      const study::HandRow& row = audio ? person.heard : person.held;
      fmt::print("| {} | {} | {} | {:.0f} | {:.2f} | {:.3f} | {:.3f} | {:.0f} | {:.3f} |\n", person.seed,
                 person.voice, audio ? "yes" : "no", 1e3 * row.over.notice_s, row.over.jerk_ratio,
                 row.mouth_change, row.last_change, 1e3 * row.over.recover_s, row.over.mouth_mm);
    }
  fmt::print(
      "\nnotice, recover: inf where it does not happen in time\n"
      "jerk: of mouth and jaw about the change, over that of whoever answers then without one\n"
      "mouth change: mean difference that the hand makes to weights of mouth and jaw that claim to be seen; "
      "last: in the last such frame\n"
      "mouth: mean error of the face's vertices while the hand is there\n");
  return {};
}

}  // namespace

void add_study_hand(Commands& commands, Command study) {
  auto options = std::make_shared<StudyHandOptions>();
  const Command command = commands.add_under(
      study, "hand",
      "A hand before the mouth of somebody who speaks and wears a headset, with and without a microphone "
      "(needs mien-media)",
      "mien study hand --sheet hand.png", [options] { return run_study_hand(*options); });
  command.add_option("--rig", options->rig, "Rig of cameras (default: rigs/headset.toml)");
  command.add_option("--model", options->model, "Model (default: models/headset.safetensors)");
  command.add_option("--people", options->request.people, "Who speaks, a seed each")
      .in_range(1, 1000)
      .show_default();
  command.add_option("--hand-seconds", options->request.hand_s, "How long the hand is there")
      .number_between(0.2, 4.0)
      .show_default();
  command.add_option("--sheet", options->sheet,
                     "A PNG of the first one's moments: what a camera sees, the face, and what is shown");
  command.add_option("--film", options->film,
                     "An MP4 of the first one, with sound: the same pictures, moving");
  add_seed_option(command, options->request.seed, "Of the first one");
  command.add_flag("--json", options->json, "Print one JSON object");
}

}  // namespace mien::app
