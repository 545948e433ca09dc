#include "app/study/study_lag.h"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <utility>

#include "app/json_output.h"
#include "app/media_helper.h"
#include "app/seed_option.h"
#include "app/study/spoken_scene.h"
#include "mien/study/speech/lag_study.h"

namespace mien::app {
namespace {

struct StudyLagOptions {
  study::LagRequest request;
  double by_ms = 1e3 * study::LagRequest().by_s;
  std::string rig;
  bool json = false;
};

/// Null where there is none.
Json json_of(const std::optional<double>& value) {
  return value ? Json(*value) : Json();
}

Json lag_row_json(const study::LagPerson& person, const study::LagRow& row) {
  return {{"seed", person.seed},
          {"voice", person.voice},
          {"lag_s", row.lag_s},
          {"believed_s", json_of(row.followed.believed_s)},
          {"believed_share", row.followed.believed_share},
          {"offset_s", row.followed.offset_s},
          {"held_mouth_mm", row.held.mouth_mm},
          {"heard_mouth_mm", row.heard.mouth_mm},
          {"retimed_mouth_mm", row.retimed.mouth_mm},
          {"heard_jaw", json_of(row.heard.jaw)},
          {"retimed_jaw", json_of(row.retimed.jaw)}};
}

std::string figure(const std::optional<double>& value, int digits) {
  return value ? fmt::format("{:.{}f}", *value, digits) : "none";
}

Result<void> run_study_lag(const StudyLagOptions& options) {
  study::LagRequest request = options.request;
  request.by_s = 1e-3 * options.by_ms;
  MIEN_TRY_ASSIGN(const study::SpokenScene scene, read_spoken_scene(options.rig));
  MIEN_TRY_ASSIGN(const auto people,
                  study::study_lag(request, scene, speaker_by_helper(), terminal_progress("lag")));
  clear_progress();
  if (options.json) {
    Json rows = Json::array();
    for (const study::LagPerson& person : people)
      for (const study::LagRow& row : person.rows) rows.push_back(lag_row_json(person, row));
    print_json({{"rig", scene.rig.name}, {"by_s", request.by_s}, {"rows", std::move(rows)}});
    return {};
  }
  fmt::print("{}: sound {:g} ms early, on time and {:g} ms late; sensors are lost again and again\n\n",
             scene.rig.name, options.by_ms, options.by_ms);
  fmt::print(
      "| seed | voice | sound ms | believed from s | believed | offset ms | held mm | sound mm | retimed mm "
      "| jaw | retimed jaw |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const study::LagPerson& person : people)
    for (const study::LagRow& row : person.rows)
      fmt::print("| {} | {} | {:+.0f} | {} | {:.0f} % | {:+.0f} | {:.3f} | {:.3f} | {:.3f} | {} | {} |\n",
                 person.seed, person.voice, 1e3 * row.lag_s, figure(row.followed.believed_s, 1),
                 100 * row.followed.believed_share, 1e3 * row.followed.offset_s, row.held.mouth_mm,
                 row.heard.mouth_mm, row.retimed.mouth_mm, figure(row.heard.jaw, 2),
                 figure(row.retimed.jaw, 2));
  fmt::print(
      "\nSound that is late cannot be asked for before it is heard: it is believed, and shown as it "
      "comes.\n");
  return {};
}

}  // namespace

void add_study_lag(Commands& commands, Command study) {
  auto options = std::make_shared<StudyLagOptions>();
  const Command command = commands.add_under(
      study, "lag",
      "Sound that is early or late against the face: how the lag is found, and what retiming is worth while "
      "sensors are lost (needs mien-media)",
      "mien study lag --by 80 --people 1", [options] { return run_study_lag(*options); });
  add_spoken_rig_option(command, options->rig);
  command.add_option("--people", options->request.people, "Who reads for two minutes, a seed each")
      .in_range(1, 1000)
      .show_default();
  command.add_option("--by", options->by_ms, "How early and how late sound is, ms")
      .number_between(1.0, 500.0)
      .show_default();
  add_seed_option(command, options->request.seed, "Of the first one");
  command.add_flag("--json", options->json, "Print one JSON object");
}

}  // namespace mien::app
