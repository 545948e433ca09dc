#include "lab/commands/study_lost.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "app/film.h"
#include "app/json_output.h"
#include "app/media_helper.h"
#include "app/seed_option.h"
#include "lab/commands/spoken_scene.h"
#include "lab/speech/lost_sensors_study.h"
#include "mien/builtin_face/builtin_face.h"

namespace mien::lab {
namespace {

struct StudyLostOptions {
  LostSensorsRequest request;
  std::string rig, film;
  bool json = false;
};

app::Json row_json(const LostSensorsPerson& person, const LostSensorsRow& row) {
  return {{"seed", person.seed},
          {"voice", person.voice},
          {"audio", row.audio},
          {"jerk_ratio", row.over.jerk_ratio},
          {"notice_s", row.over.notice_s},
          {"recover_s", row.over.recover_s},
          {"mouth_mm", row.over.mouth_mm}};
}

/// The first person's loss, as it was and as it is shown with a microphone.
Result<void> film(const LostSensorsPerson& person, const std::string& out) {
  app::FilmOptions options;
  options.sound = person.sound;
  MIEN_TRY(app::film_comparison(builtin_face::make_builtin(), person.truth, person.shown_heard, 0, options,
                                out, app::terminal_progress("film")));
  return {};
}

Result<void> run_study_lost(const StudyLostOptions& options) {
  if (!options.film.empty()) MIEN_TRY(app::check_output(options.film, {".mp4"}));
  MIEN_TRY_ASSIGN(const SpokenScene scene, read_spoken_scene(options.rig));
  MIEN_TRY_ASSIGN(const auto people, study_lost_sensors(options.request, scene, app::speaker_by_helper(),
                                                        app::terminal_progress("lost sensors")));
  app::clear_progress();
  if (!options.film.empty()) MIEN_TRY(film(people.front(), options.film));
  if (options.json) {
    app::Json rows = app::Json::array();
    for (const LostSensorsPerson& person : people)
      for (const LostSensorsRow* row : {&person.held, &person.heard}) rows.push_back(row_json(person, *row));
    app::print_json({{"rig", scene.rig.name}, {"lost_s", options.request.lost_s}, {"rows", std::move(rows)}});
    return {};
  }
  fmt::print("{}: all sensors are lost for {} s in the middle of a sentence\n\n", scene.rig.name,
             options.request.lost_s);
  fmt::print("| seed | voice | microphone | jerk | notice ms | recover ms | mouth mm | of held |\n");
  fmt::print("|---|---|---|---|---|---|---|---|\n");
  for (const LostSensorsPerson& person : people)
    for (const LostSensorsRow* row : {&person.held, &person.heard})
      fmt::print(
          "| {} | {} | {} | {:.2f} | {:.0f} | {:.0f} | {:.3f} | {:+.0f} % |\n", person.seed, person.voice,
          row->audio ? "yes" : "no", row->over.jerk_ratio, 1e3 * row->over.notice_s,
          1e3 * row->over.recover_s, row->over.mouth_mm,
          person.held.over.mouth_mm == 0 ? 0 : 100 * (row->over.mouth_mm / person.held.over.mouth_mm - 1));
  fmt::print(
      "\njerk: of mouth and jaw about the change, over that of whoever answers then without one\n"
      "mouth: mean error of the face's vertices meanwhile; of held: of the row without a microphone\n");
  return {};
}

}  // namespace

void add_study_lost(app::Commands& commands, app::Command study) {
  auto options = std::make_shared<StudyLostOptions>();
  const app::Command command = commands.add_under(
      study, "lost",
      "Sensors that are lost in the middle of a sentence, with and without a microphone (needs mien-media)",
      "mien study lost --rig rigs/eyewear.toml --film lost.mp4",
      [options] { return run_study_lost(*options); });
  add_spoken_rig_option(command, options->rig);
  command.add_option("--people", options->request.people, "Who speaks, a seed each")
      .in_range(1, 1000)
      .show_default();
  command.add_option("--lost-seconds", options->request.lost_s, "How long nothing comes")
      .number_between(0.2, 4.0)
      .show_default();
  command.add_option("--film", options->film,
                     "An MP4 of the first one's loss: truth, what is shown, and the error");
  app::add_seed_option(command, options->request.seed, "Of the first one");
  command.add_flag("--json", options->json, "Print one JSON object");
}

}  // namespace mien::lab
