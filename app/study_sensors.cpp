#include "app/study_sensors.h"
#include "app/seed_option.h"

#include <fmt/format.h>

#include <memory>

#include "app/json_output.h"
#include "mien/core/files.h"
#include "mien/eyewear/marker_network.h"
#include "mien/eyewear/markers.h"
#include "mien/sensor/rig.h"
#include "mien/study/minute_study.h"
#include "mien/study/sensors_report.h"
#include "mien/study/sensors_study.h"

namespace mien::app {
namespace {

struct Options {
  study::SensorsRequest request;
  std::string rig;
  std::string markers;
  std::string model;
  std::string out;
  bool json = false;
};

using Json = nlohmann::ordered_json;

/// Of the whole study's time.
constexpr double kFaithfulShare = 0.5;

Json to_json(const study::SensorsRow& row) {
  return {{"mean_mm", row.all.mean_mm},
          {"rmse_mm", row.all.rmse_mm},
          {"eyes_mm", row.eyes_nose.mean_mm},
          {"mouth_mm", row.mouth.mean_mm},
          {"eyes_rmse_mm", row.eyes_nose.rmse_mm},
          {"mouth_rmse_mm", row.mouth.rmse_mm}};
}

Json to_json(const study::SensorsMethod& method, const std::vector<std::string>& markers) {
  Json out = to_json(method.overall);
  out["sensors"] = method.sensors;
  out["wearers"] = Json::array();
  for (const study::SensorsRow& row : method.wearers) out["wearers"].push_back(to_json(row));
  for (std::size_t s = 0; s < study::kTestSets; ++s)
    out["sets"][std::string(study::test_set_name(static_cast<study::TestSet>(s)))] = to_json(method.sets[s]);
  out["tests"] = Json::array();
  for (const study::SensorsRow& row : method.tests) out["tests"].push_back(to_json(row));
  for (std::size_t m = 0; m < markers.size(); ++m)
    out["markers"][markers[m]] = {{"mean_mm", method.markers[m].mean_mm},
                                  {"rmse_mm", method.markers[m].rmse_mm}};
  return out;
}

void print_study(const study::SensorsStudy& study, const study::MinuteStudy& minute, const Options& options) {
  Json out = {{"rig", options.rig}, {"wearers", options.request.wearers}, {"seed", options.request.seed}};
  for (const study::SensorsMethod* method : {&study.faithful, &study.faithful16, &study.mean_pose})
    out[method->name] = to_json(*method, study.markers);
  for (const study::SensorsMethod& method : minute.methods)
    out["minute"][method.name] = to_json(method, study.markers);
  for (const study::SensorsMethod& method : minute.conditions)
    out["minute"]["conditions"][method.name] = to_json(method, study.markers);
  out["training"] = Json::array();
  for (const study::SensorsTraining& training : study.training)
    out["training"].push_back(
        {{"samples", training.samples}, {"outliers", training.outliers}, {"share", training.share}});
  print_json(out);
}

void print_table(const study::SensorsStudy& study, const study::MinuteStudy& minute) {
  const auto line = [](const std::string& name, const study::SensorsRow& row) {
    fmt::print("{:<24} {:7.2f} {:7.2f} {:11.2f} {:7.2f}\n", name, row.all.mean_mm, row.all.rmse_mm,
               row.eyes_nose.mean_mm, row.mouth.mean_mm);
  };
  fmt::print("{:<24} {:>7} {:>7} {:>11} {:>7}\n", "mm", "mean", "RMSE", "eyes, nose", "mouth");
  for (const study::SensorsMethod* method : {&study.faithful, &study.faithful16, &study.mean_pose})
    line(method->sensors > 0 ? fmt::format("{}, {} sensors", method->name, method->sensors) : method->name,
         method->overall);
  fmt::print("\nafter one minute\n");
  for (const auto* methods : {&minute.methods, &minute.conditions})
    for (const study::SensorsMethod& method : *methods)
      line(method.sensors > 0 ? fmt::format("{}, {} sensors", method.name, method.sensors) : method.name,
           method.overall);
  fmt::print("\n{:<24} {:>7} {:>7} {:>11} {:>7}\n", "faithful, by wearer", "", "", "", "");
  for (std::size_t w = 0; w < study.faithful.wearers.size(); ++w)
    line(fmt::format("{}, {} of {} out", w + 1, study.training[w].outliers, study.training[w].samples),
         study.faithful.wearers[w]);
  fmt::print("\nby expressions\n");
  for (std::size_t s = 0; s < study::kTestSets; ++s)
    line(std::string(study::test_set_name(static_cast<study::TestSet>(s))), study.faithful.sets[s]);
  fmt::print("\n{:<24} {:>7} {:>7} {:>11} {:>7}\n", "by marker, mean", "faithf.", "16", "knowing 0", "");
  for (std::size_t m = 0; m < study.markers.size(); ++m)
    fmt::print("{:<24} {:7.2f} {:7.2f} {:11.2f}\n", fmt::format("{} {}", m + 1, study.markers[m]),
               study.faithful.markers[m].mean_mm, study.faithful16.markers[m].mean_mm,
               study.mean_pose.markers[m].mean_mm);
}

Result<void> run(Options options) {
  if (!options.out.empty()) MIEN_TRY(check_output(options.out, {".html"}));
  if (options.rig.empty()) {
    MIEN_TRY_ASSIGN(options.rig, find_resource("rigs/eyewear.toml"));
  }
  if (options.markers.empty()) {
    MIEN_TRY_ASSIGN(options.markers, find_resource("rigs/markers.toml"));
  }
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(options.rig));
  MIEN_TRY_ASSIGN(const eyewear::MarkerSet markers, eyewear::read_markers(options.markers));
  if (options.model.empty()) {
    MIEN_TRY_ASSIGN(options.model, find_resource("models/eyewear.safetensors"));
  }
  MIEN_TRY_ASSIGN(const eyewear::MarkerNetworkFile model, eyewear::read_marker_network(options.model));
  const Progress shown = terminal_progress("sensors");
  MIEN_TRY_ASSIGN(
      const study::SensorsStudy study,
      study::study_sensors(options.request, rig, markers, [&](double part, std::string_view what) {
        return shown(kFaithfulShare * part * 0.999, what);
      }));
  MIEN_TRY_ASSIGN(
      const study::MinuteStudy minute,
      study::study_minute(options.request, rig, markers, model, [&](double part, std::string_view what) {
        return shown(kFaithfulShare + (1 - kFaithfulShare) * part, what);
      }));
  clear_progress();
  const std::string subtitle =
      fmt::format("{} virtual wearers, seed {}", options.request.wearers, options.request.seed);
  if (!options.out.empty()) MIEN_TRY(study::sensors_report(study, minute, subtitle).write(options.out));
  if (options.json) {
    options.rig = rig.name;
    print_study(study, minute, options);
    return {};
  }
  fmt::print("Markers from photo-reflective eyewear: {}\n\n", subtitle);
  print_table(study, minute);
  if (!options.out.empty()) fmt::print("report: {}\n", options.out);
  return {};
}

}  // namespace

void add_study_sensors(Commands& commands, CLI::App* study) {
  auto options = std::make_shared<Options>();
  CLI::App* command = commands.add_under(
      study, "sensors", "How well photo-reflective eyewear tells where markers on the face are",
      "mien study sensors --wearers 3 --out sensors.html", [options] { return run(*options); });
  command->add_option("--rig", options->rig, "Eyewear rig (default: rigs/eyewear.toml)");
  command->add_option("--markers", options->markers, "Markers of the truth (default: rigs/markers.toml)");
  command->add_option("--model", options->model,
                      "The learned method's model (default: models/eyewear.safetensors)");
  command->add_option("--wearers", options->request.wearers, "Virtual wearers")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  add_seed_option(command, options->request.seed, "Of the wearers, their glasses and what they do");
  command->add_option("--out", options->out, "Write a self-contained HTML page with tables and curves");
  command->add_flag("--json", options->json, "Print one JSON object");
}

}  // namespace mien::app
