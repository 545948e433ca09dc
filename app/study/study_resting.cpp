#include "app/study/study_resting.h"

#include <fmt/format.h>

#include <memory>
#include <utility>
#include <vector>

#include "app/json_output.h"
#include "app/performance.h"
#include "app/seed_option.h"
#include "mien/shaping/resting_face.h"
#include "mien/study/resting_study.h"

namespace mien::app {
namespace {

struct StudyRestingOptions {
  std::vector<std::string> files;
  study::RestingRequest request;
  bool json = false;
};

struct RecordedRests {
  std::string file;
  std::vector<study::BeforeAfter> rests;
};

Json pair_json(const study::BeforeAfter& pair) {
  return {{"before", pair.before}, {"after", pair.after}};
}

Json resting_json(const StudyRestingOptions& options, const study::RestingStudy& study,
                  const std::vector<RecordedRests>& recorded) {
  Json out = {{"wearers", options.request.wearers},
              {"seconds", options.request.seconds},
              {"seed", options.request.seed},
              {"results", Json::array()},
              {"smiles", Json::array()},
              {"recorded", Json::array()}};
  for (const study::RestingResult& result : study.results) {
    Json row = {{"script", std::string(result.script)},
                {"kind", std::string(study::kRestingKindNames.at(static_cast<std::size_t>(result.kind)))},
                {"resting", pair_json(result.resting)},
                {"active", pair_json(result.active)},
                {"all", pair_json(result.all)},
                {"wide", pair_json(result.wide)},
                {"curve", result.curve}};
    if (result.blink_f1) row["blink_f1"] = pair_json(*result.blink_f1);
    out["results"].push_back(std::move(row));
  }
  for (const study::LongSmile& smile : study.smiles)
    out["smiles"].push_back({{"smile", smile.smile}, {"shown", smile.shown}});
  for (const RecordedRests& one : recorded) {
    Json shapes = Json::object();
    for (std::size_t i = 0; i < face::kShapeCount; ++i)
      shapes[std::string(face::kShapeNames[i])] = pair_json(one.rests[i]);
    out["recorded"].push_back({{"file", one.file}, {"rests", std::move(shapes)}});
  }
  return out;
}

void print_resting(const study::RestingStudy& study, const std::vector<RecordedRests>& recorded) {
  fmt::print("| script | face | resting | active | all frames | blink F1 | eyeWide shown |\n");
  fmt::print("|---|---|---|---|---|---|---|\n");
  for (const study::RestingResult& r : study.results)
    fmt::print(
        "| {} | {} | {:.4f} -> {:.4f} | {:.4f} -> {:.4f} | {:.4f} -> {:.4f} | {} | {:.3f} -> {:.3f} |\n",
        r.script, study::kRestingKindNames.at(static_cast<std::size_t>(r.kind)), r.resting.before,
        r.resting.after, r.active.before, r.active.after, r.all.before, r.all.after,
        r.blink_f1 ? fmt::format("{:.3f} -> {:.3f}", r.blink_f1->before, r.blink_f1->after) : "-",
        r.wide.before, r.wide.after);
  fmt::print("\nResting error in each 5 s of the first minute\n");
  for (const study::RestingResult& r : study.results)
    fmt::print("{:<12} {:<13} {:.3f}\n", r.script,
               study::kRestingKindNames.at(static_cast<std::size_t>(r.kind)), fmt::join(r.curve, " "));
  fmt::print("\nA smile from 20 to 60 s, shown every 5 s from 5 s on\n");
  for (const study::LongSmile& smile : study.smiles)
    fmt::print("{:.2f}: {:.3f}\n", smile.smile, fmt::join(smile.shown, " "));
  for (const RecordedRests& one : recorded) {
    fmt::print("\n{}: the lower third of each shape after 30 s\n", one.file);
    study::BeforeAfter sum;
    for (std::size_t i = 0; i < face::kShapeCount; ++i) {
      if (shaping::kRestingRules[i] == shaping::RestingRule::none) continue;
      sum.before += one.rests[i].before;
      sum.after += one.rests[i].after;
      fmt::print("{:<16} {:.4f} -> {:.4f}\n", face::kShapeNames[i], one.rests[i].before, one.rests[i].after);
    }
    fmt::print("{:<16} {:.4f} -> {:.4f}\n", "sum", sum.before, sum.after);
  }
}

Result<void> run_study_resting(const StudyRestingOptions& options) {
  std::vector<RecordedRests> recorded;
  for (const std::string& file : options.files) {
    MIEN_TRY_ASSIGN(const Performance performance, load_performance(file));
    recorded.push_back({file, study::rests_of(performance.motion)});
  }
  MIEN_TRY_ASSIGN(const study::RestingStudy study,
                  study::study_resting(options.request, terminal_progress("resting")));
  clear_progress();
  if (options.json)
    print_json(resting_json(options, study, recorded));
  else
    print_resting(study, recorded);
  return {};
}

}  // namespace

void add_study_resting(Commands& commands, Command study) {
  auto options = std::make_shared<StudyRestingOptions>();
  const Command command = commands.add_under(
      study, "resting",
      "What learning the face at rest from the last 30 s does for faces that rest otherwise",
      "mien study resting --wearers 30", [options] { return run_study_resting(*options); });
  command.add_option("files", options->files, "Live Link Face CSVs, or takes with truth: their rests too");
  command
      .add_option("--wearers", options->request.wearers,
                  "Virtual wearers for each script, a third of each kind")
      .in_range(3, 10000)
      .show_default();
  command.add_option("--seconds", options->request.seconds, "Length of each performance")
      .number_between(61.0, 3600.0)
      .show_default();
  add_seed_option(command, options->request.seed, "Of the virtual wearers");
  command.add_flag("--json", options->json, "Print one JSON object");
}

}  // namespace mien::app
