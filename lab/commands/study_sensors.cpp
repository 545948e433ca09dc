#include "lab/commands/studies.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <utility>

#include "app/chosen_face.h"
#include "app/json_output.h"
#include "app/performance.h"
#include "app/seed_option.h"
#include "lab/commands/output.h"
#include "lab/eyewear/minute_study.h"
#include "lab/eyewear/sensors_report.h"
#include "lab/eyewear/sensors_study.h"
#include "mien/builtin_face/markers.h"
#include "mien/eyewear/light_grid.h"
#include "mien/eyewear/marker_network.h"
#include "mien/sensor/rig.h"

namespace mien::lab {
namespace {

struct StudySensorsOptions {
  SensorsRequest request;
  std::string rig;
  std::string markers;
  std::string model;
  std::string face;
  std::vector<std::string> motions;
  Output to;
};

/// Of the whole study's time.
constexpr double kFaithfulShare = 0.5;

app::Json to_json(const SensorsMethod& method, const std::vector<std::string>& markers) {
  app::Json out = json_of(method.overall, sensors_columns());
  out["sensors"] = method.sensors;
  out["wearers"] = json_of(method.wearers, sensors_columns());
  for (std::size_t s = 0; s < kTestSets; ++s)
    out["sets"][std::string(sensors_test_set_name(static_cast<SensorsTestSet>(s)))] =
        json_of(method.sets[s], sensors_columns());
  out["tests"] = json_of(method.tests, sensors_columns());
  for (std::size_t m = 0; m < markers.size(); ++m)
    out["markers"][markers[m]] = {{"mean_mm", method.markers[m].mean_mm},
                                  {"rmse_mm", method.markers[m].rmse_mm}};
  return out;
}

void add_minute(const MinuteStudy& minute, const builtin_face::MarkerSet& markers, app::Json& out) {
  std::vector<std::string> names;
  for (const builtin_face::Marker& marker : markers.markers) names.push_back(marker.name);
  for (const SensorsMethod& method : minute.methods) out["minute"][method.name] = to_json(method, names);
  for (const SensorsMethod& method : minute.conditions)
    out["minute"]["conditions"][method.name] = to_json(method, names);
}

app::Json to_json(const SensorsStudy& study, const MinuteStudy& minute,
                  const builtin_face::MarkerSet& markers, const StudySensorsOptions& options) {
  app::Json out = {
      {"rig", options.rig}, {"wearers", options.request.wearers}, {"seed", options.request.seed}};
  for (const SensorsMethod* method : {&study.faithful, &study.faithful16, &study.mean_pose})
    out[method->name] = to_json(*method, study.markers);
  add_minute(minute, markers, out);
  out["training"] = app::Json::array();
  for (const SensorsTraining& training : study.training)
    out["training"].push_back(
        {{"samples", training.samples}, {"outliers", training.outliers}, {"share", training.share}});
  return out;
}

/// The learned method alone, on another face or in others' performances.
Result<void> run_scene(const StudySensorsOptions& options, const sensor::Rig& rig,
                       const builtin_face::MarkerSet& markers, const eyewear::MarkerNetworkFile& model) {
  MinuteScene scene;
  if (!options.face.empty()) {
    MIEN_TRY_ASSIGN(scene.face, app::chosen_face(options.face, app::terminal_progress("face")));
  }
  for (const std::string& path : options.motions) {
    MIEN_TRY_ASSIGN(app::Performance performance, app::load_performance(path));
    scene.motions.push_back(std::move(performance.motion));
    scene.motions.back().name = std::filesystem::path(path).filename().string();
  }
  MIEN_TRY_ASSIGN(const MinuteStudy minute, study_minute(options.request, rig, markers, model, scene,
                                                         app::terminal_progress("sensors")));
  app::Json out = {{"face", options.face}, {"seed", options.request.seed}, {"motions", options.motions}};
  add_minute(minute, markers, out);
  std::vector<std::string> motions;
  for (const face::Motion& motion : scene.motions) motions.push_back(motion.name);
  const std::string subtitle = fmt::format("face {}, seed {}", options.face, options.request.seed);
  return put_out(options.to, minute_report(minute, motions, subtitle), out);
}

Result<void> run_study_sensors(StudySensorsOptions options) {
  MIEN_TRY(check_page(options.to));
  MIEN_TRY_ASSIGN(options.rig, app::path_or(options.rig, "rigs/eyewear.toml"));
  MIEN_TRY_ASSIGN(options.markers, app::path_or(options.markers, "rigs/markers.toml"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(options.rig));
  if (eyewear::photo_sensors(rig).empty())
    return fail(ErrorCode::mismatch, "the rig has no photo-reflective sensors", options.rig,
                "use one of glasses, such as rigs/eyewear.toml");
  MIEN_TRY_ASSIGN(const builtin_face::MarkerSet markers, builtin_face::read_markers(options.markers));
  MIEN_TRY_ASSIGN(options.model, app::path_or(options.model, "models/eyewear.safetensors"));
  MIEN_TRY_ASSIGN(const eyewear::MarkerNetworkFile model, eyewear::read_marker_network(options.model));
  if (!options.face.empty() || !options.motions.empty()) return run_scene(options, rig, markers, model);
  const Progress shown = app::terminal_progress("sensors");
  MIEN_TRY_ASSIGN(const SensorsStudy study,
                  study_sensors(options.request, rig, markers, [&](double part, std::string_view what) {
                    return shown(kFaithfulShare * part * 0.999, what);
                  }));
  MIEN_TRY_ASSIGN(
      const MinuteStudy minute,
      study_minute(options.request, rig, markers, model, {}, [&](double part, std::string_view what) {
        return shown(kFaithfulShare + (1 - kFaithfulShare) * part, what);
      }));
  const std::string subtitle =
      fmt::format("{} virtual wearers, seed {}", options.request.wearers, options.request.seed);
  options.rig = rig.name;
  return put_out(options.to, sensors_report(study, minute, subtitle),
                 to_json(study, minute, markers, options));
}

}  // namespace

void add_study_sensors(app::Commands& commands, app::Command study) {
  auto options = std::make_shared<StudySensorsOptions>();
  const app::Command command = commands.add_under(
      study, "sensors", "How well photo-reflective eyewear locates markers on the face",
      "mien study sensors --wearers 3 --out sensors.html", [options] { return run_study_sensors(*options); });
  command.add_option("--rig", options->rig, "Eyewear rig (default: rigs/eyewear.toml)");
  command.add_option("--markers", options->markers, "Markers of the truth (default: rigs/markers.toml)");
  command.add_option("--model", options->model,
                     "The learned method's model (default: models/eyewear.safetensors)");
  command.add_option("--face", options->face,
                     "Another wearer, for the learned method alone: an ICT-FaceKit folder, a .glb or .vrm");
  command.add_option("--motion", options->motions,
                     "A performance to test on instead of the protocol's expressions, for the learned method "
                     "alone: a Live Link Face CSV or a take; may be given often");
  command.add_option("--wearers", options->request.wearers, "Virtual wearers")
      .in_range(1, 1000)
      .show_default();
  app::add_seed_option(command, options->request.seed, "Of the wearers, their glasses and what they do");
  command.add_option("--out", options->to.out, "Write a self-contained HTML page with the tables");
  app::add_json_flag(command, options->to.json);
}

}  // namespace mien::lab
