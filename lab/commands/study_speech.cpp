#include "lab/commands/study_speech.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <utility>

#include "app/json_output.h"
#include "app/media_helper.h"
#include "app/seed_option.h"
#include "lab/speech/phone_labels.h"
#include "lab/speech/speech_confidence.h"
#include "lab/speech/speech_study.h"
#include "mien/core/files.h"

namespace mien::lab {
namespace {

struct StudySpeechOptions {
  SpeechRequest request;
  std::vector<std::string> recordings;
  std::string model, write;
  bool json = false;
};

/// The labels of FILE.wav: FILE.phone.json or FILE_phone.lab.
Result<LabelledSound> read_labelled(const std::filesystem::path& path) {
  LabelledSound sound{.name = path.filename().string(), .sound = {}, .closures = {}};
  MIEN_TRY_ASSIGN(const auto bytes, read_file(path));
  MIEN_TRY_ASSIGN(sound.sound, parse_wav(bytes, path.string()));
  const std::filesystem::path stem = path.parent_path() / path.stem();
  for (const char* ending : {".phone.json", "_phone.lab"}) {
    const std::filesystem::path labels = stem.string() + ending;
    if (!std::filesystem::exists(labels)) continue;
    MIEN_TRY_ASSIGN(const std::string text, read_text(labels));
    MIEN_TRY_ASSIGN(sound.closures, parse_phone_labels(text, labels.string()));
    return sound;
  }
  return fail(ErrorCode::not_found, "nobody says when its phones are spoken", path.string(),
              "put their times beside it, as " + stem.filename().string() + ".phone.json or _phone.lab");
}

app::Json row_json(const SpeechRow& row, bool with_jaw) {
  app::Json out = {{"method", row.method},
                   {"sound", row.sound},
                   {"closures", row.closures.truths},
                   {"heard", row.closures.heard},
                   {"recall", row.closures.recall()},
                   {"false", row.closures.false_share()},
                   {"late_s", row.late_s}};
  if (with_jaw) out["jaw_correlation"] = row.jaw_correlation;
  return out;
}

void print_rows(const std::vector<SpeechRow>& rows, bool with_jaw) {
  fmt::print("| sound | way | closures | recall | false | late ms |{}\n|---|---|---|---|---|---|{}\n",
             with_jaw ? " jaw |" : "", with_jaw ? "---|" : "");
  for (const SpeechRow& row : rows)
    fmt::print("| {} | {} | {} | {:.2f} | {:.2f} | {:.0f} |{}\n", row.sound, row.method, row.closures.truths,
               row.closures.recall(), row.closures.false_share(), 1e3 * row.late_s,
               with_jaw ? fmt::format(" {:.2f} |", row.jaw_correlation) : "");
}

/// Measures what the network's answers are worth and writes it so, on voices that nothing else hears.
Result<void> write_confidence(const StudySpeechOptions& options, speech::SpeechNetworkFile& network) {
  constexpr std::uint64_t kMeasuredOn = 2001;
  MIEN_TRY_ASSIGN(network.confidence,
                  measure_speech_confidence(network,
                                            {.voices = synthetic::VoiceUse::confidence,
                                             .passages = options.request.passages,
                                             .seed = kMeasuredOn},
                                            app::speaker_by_helper(), app::terminal_progress("confidence")));
  return speech::write_speech_network(options.write, network);
}

Result<void> run_study_speech(const StudySpeechOptions& options) {
  SpeechRequest request = options.request;
  for (const std::string& path : options.recordings) {
    MIEN_TRY_ASSIGN(LabelledSound sound, read_labelled(path));
    request.recorded.push_back(std::move(sound));
  }
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
  app::clear_progress();
  if (options.json) {
    app::Json out = {{"model", model.string()}, {"seed", request.seed}, {"passages", request.passages}};
    const auto add = [&](const char* name, const std::vector<SpeechRow>& rows, bool with_jaw) {
      out[name] = app::Json::array();
      for (const SpeechRow& row : rows) out[name].push_back(row_json(row, with_jaw));
    };
    add("conditions", study.conditions, true);
    add("languages", study.languages, true);
    add("recorded", study.recorded, false);
    out["others"] = app::Json::array();
    for (const OtherRow& row : study.others)
      out["others"].push_back({{"method", row.method}, {"sound", row.sound}, {"moving", row.moving}});
    out["confidence"] = app::Json::array();
    for (const SpeechConfidenceRow& row : confidence)
      out["confidence"].push_back({{"sound", row.sound},
                                   {"frames", row.frames},
                                   {"mouth_calibration_error", row.mouth.expected_error()},
                                   {"jaw_calibration_error", row.jaw.expected_error()}});
    app::print_json(out);
    return {};
  }
  print_rows(study.conditions, true);
  fmt::print("\nClean, by language\n\n");
  print_rows(study.languages, true);
  if (!study.recorded.empty()) {
    fmt::print("\nRecordings\n\n");
    print_rows(study.recorded, false);
  }
  fmt::print("\nSounds that are no speech: share of frames in which the mouth moves by more than 0.05\n\n");
  fmt::print("| sound | way | moving |\n|---|---|---|\n");
  for (const OtherRow& row : study.others)
    fmt::print("| {} | {} | {:.2f} % |\n", row.sound, row.method, 100 * row.moving);
  if (!confidence.empty())
    fmt::print(
        "\nExpected calibration error of the network's confidence\n\n| sound | frames | mouth | jaw "
        "|\n|---|---|---|---|\n");
  for (const SpeechConfidenceRow& row : confidence)
    fmt::print("| {} | {} | {:.3f} | {:.3f} |\n", row.sound, row.frames, row.mouth.expected_error(),
               row.jaw.expected_error());
  return {};
}

}  // namespace

void add_study_speech(app::Commands& commands, app::Command study) {
  auto options = std::make_shared<StudySpeechOptions>();
  const app::Command command = commands.add_under(
      study, "speech", "How well mouth and jaw are heard, by four ways beside each other (needs mien-media)",
      "mien study speech talk.wav --passages 2", [options] { return run_study_speech(*options); });
  command.add_option("recordings", options->recordings,
                     "WAV files whose phones' times stand beside them (FILE.phone.json or FILE_phone.lab)");
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
  app::add_json_flag(command, options->json);
}

}  // namespace mien::lab
