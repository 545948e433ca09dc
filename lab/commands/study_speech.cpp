#include "lab/commands/studies.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <utility>

#include "app/json_output.h"
#include "app/media_helper.h"
#include "app/seed_option.h"
#include "lab/commands/output.h"
#include "lab/speech/speech_study.h"

namespace mien::lab {
namespace {

struct StudySpeechOptions {
  SpeechRequest request;
  std::string model, write;
  Output to;
};

const Columns<SpeechRow>& speech_columns() {
  static const Columns<SpeechRow> columns = {
      {"", "sound", "{}", &SpeechRow::sound},
      {"method", "way", "{}", &SpeechRow::method},
      {"sound", "", "", &SpeechRow::sound},
      {"closures", "closures", "{}", [](const SpeechRow& row) { return row.closures.truths; }},
      {"heard", "", "", [](const SpeechRow& row) { return row.closures.heard; }},
      {"recall", "recall", "{:.2f}", [](const SpeechRow& row) { return row.closures.recall(); }},
      {"false", "false", "{:.2f}", [](const SpeechRow& row) { return row.closures.false_share(); }},
      {"late_s", "late ms", "{:.0f}", &SpeechRow::late_s, 1e3},
      {"jaw_correlation", "jaw", "{:.2f}", &SpeechRow::jaw_correlation}};
  return columns;
}

const Columns<OtherRow>& other_columns() {
  static const Columns<OtherRow> columns = {{"", "sound", "{}", &OtherRow::sound},
                                            {"method", "way", "{}", &OtherRow::method},
                                            {"sound", "", "", &OtherRow::sound},
                                            {"moving", "moving, %", "{:.2f}", &OtherRow::moving, 100}};
  return columns;
}

const Columns<SpeechConfidenceRow>& speech_confidence_columns() {
  using Row = SpeechConfidenceRow;
  static const Columns<Row> columns = {
      {"sound", "sound", "{}", &Row::sound},
      {"frames", "frames", "{}", &Row::frames},
      {"mouth_calibration_error", "mouth", "{:.3f}",
       [](const Row& row) { return row.mouth.expected_error(); }},
      {"jaw_calibration_error", "jaw", "{:.3f}", [](const Row& row) { return row.jaw.expected_error(); }}};
  return columns;
}

/// Measures what the network's answers are worth and writes it so, on voices that nothing else hears.
Result<void> write_confidence(const StudySpeechOptions& options, speech::SpeechNetworkFile& network) {
  constexpr std::uint64_t kMeasuredVoices = 2001;
  MIEN_TRY_ASSIGN(network.confidence,
                  measure_speech_confidence(network,
                                            {.voices = synthetic::VoiceUse::confidence,
                                             .passages = options.request.passages,
                                             .seed = kMeasuredVoices},
                                            app::speaker_by_helper(), app::terminal_progress("confidence")));
  return speech::write_speech_network(options.write, network);
}

Result<void> run_study_speech(const StudySpeechOptions& options) {
  const SpeechRequest& request = options.request;
  MIEN_TRY_ASSIGN(const std::filesystem::path model,
                  app::path_or(options.model, "models/speech.safetensors"));
  MIEN_TRY_ASSIGN(speech::SpeechNetworkFile network, speech::read_speech_network(model));
  if (!options.write.empty()) {
    MIEN_TRY(app::check_output(options.write, {".safetensors"}));
    MIEN_TRY(write_confidence(options, network));
  }
  MIEN_TRY_ASSIGN(const SpeechStudy study,
                  study_speech(request, app::speaker_by_helper(), network, app::terminal_progress("speech")));
  MIEN_TRY_ASSIGN(
      const std::vector<SpeechConfidenceRow> confidence,
      study_speech_confidence(
          network, {.voices = synthetic::VoiceUse::test, .passages = request.passages, .seed = request.seed},
          app::speaker_by_helper(), app::terminal_progress("confidence")));
  app::Json out = {{"model", model.string()}, {"seed", request.seed}, {"passages", request.passages}};
  measure::Report report("How well mouth and jaw are heard",
                         fmt::format("model {}, {} passages, seed {}", model.filename().string(),
                                     request.passages, request.seed));
  const auto add = [&](const char* name, std::string caption, const auto& rows, const auto& columns) {
    out[name] = json_of(rows, columns);
    if (!rows.empty()) report.table(table_of(std::move(caption), rows, columns));
  };
  add("conditions", "By condition", study.conditions, speech_columns());
  add("languages", "Clean, by language", study.languages, speech_columns());
  add("others", "Sounds that are no speech: share of frames in which the mouth moves by more than 0.05",
      study.others, other_columns());
  add("confidence", "Expected calibration error of the network's confidence", confidence,
      speech_confidence_columns());
  return put_out(options.to, report, out);
}

}  // namespace

void add_study_speech(app::Commands& commands, app::Command study) {
  auto options = std::make_shared<StudySpeechOptions>();
  const app::Command command = commands.add_under(
      study, "speech", "How well mouth and jaw are heard, by two ways beside each other (needs mien-media)",
      "mien study speech --passages 2", [options] { return run_study_speech(*options); });
  command.add_option("--model", options->model, "The network (default: models/speech.safetensors)");
  command.add_option("--passages", options->request.passages, "Of three lines, by each voice")
      .in_range(1, 1000)
      .show_default();
  command.add_option("--other-seconds", options->request.other_seconds, "Of each sound that is no speech")
      .number_between(5.0, 36'000.0)
      .show_default();
  command.add_option(
      "--write", options->write,
      "Measure the network's table of confidence anew first, on voices of its own, and write the "
      "network so");
  app::add_seed_option(command, options->request.seed, "Of lines, noise and rooms");
  app::add_json_flag(command, options->to.json);
}

}  // namespace mien::lab
