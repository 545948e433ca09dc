#include "app/study/study_merged.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/json_output.h"
#include "app/seed_option.h"
#include "mien/core/files.h"
#include "mien/modalities/modalities.h"
#include "mien/study/merged_study.h"

namespace mien::app {
namespace {

struct StudyMergedOptions {
  study::MergedRequest request;
  std::string rig;
  std::string models;
  bool json = false;
};

/// The faults of the kinds stand in rigs of their own: the rig that has both has none.
Result<study::MergedScene> read_scene(const StudyMergedOptions& options) {
  study::MergedScene scene;
  MIEN_TRY_ASSIGN(scene.rig, sensor::read_rig(options.rig));
  MIEN_TRY_ASSIGN(const std::filesystem::path imus, find_resource("rigs/default.toml"));
  MIEN_TRY_ASSIGN(const sensor::Rig imu_rig, sensor::read_rig(imus));
  MIEN_TRY_ASSIGN(scene.imu_faults, virt::parse_faults(imu_rig.faults_toml, imus.string()));
  MIEN_TRY_ASSIGN(const std::filesystem::path glasses, find_resource("rigs/eyewear.toml"));
  MIEN_TRY_ASSIGN(const sensor::Rig eyewear_rig, sensor::read_rig(glasses));
  MIEN_TRY_ASSIGN(scene.eyewear_faults,
                  virt::parse_eyewear_faults(eyewear_rig.faults_toml, glasses.string()));
  MIEN_TRY_ASSIGN(const std::filesystem::path models, modalities::live_model(scene.rig, options.models));
  MIEN_TRY_ASSIGN(scene.imu, model::read_model(models / "live.safetensors"));
  MIEN_TRY_ASSIGN(scene.eyewear, eyewear::read_marker_network(models / "eyewear.safetensors"));
  MIEN_TRY_ASSIGN(const std::filesystem::path markers, find_resource("rigs/markers.toml"));
  MIEN_TRY_ASSIGN(scene.markers, builtin_face::read_markers(markers));
  return scene;
}

Json to_json(const measure::Metrics& metrics) {
  return {{"mae", study::MergedPerson::mae(metrics)},
          {"mse", metrics.mse},
          {"mse_observed", metrics.mse_observed},
          {"pve_face_mm", metrics.pve_face_mm ? Json(metrics.pve_face_mm->mean) : Json()}};
}

Json to_json(const study::MergedPerson& person) {
  Json by_eyewear = Json::object();
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (person.by_eyewear[k] > 0) by_eyewear[std::string(face::kShapeNames[k])] = person.by_eyewear[k];
  return {{"frames", person.merged.frames},
          {"imu", to_json(person.imu)},
          {"eyewear", to_json(person.eyewear)},
          {"merged", to_json(person.merged)},
          {"ece", person.confidence.expected_error()},
          {"hand_overs_a_second", person.hand_overs},
          {"by_eyewear", by_eyewear}};
}

void print_row(const std::string& who, const study::MergedPerson& person) {
  const double alone = study::MergedPerson::mae(person.imu);
  const double merged = study::MergedPerson::mae(person.merged);
  double answered = 0;
  for (const double share : person.by_eyewear) answered += share / face::kShapeCount;
  const auto pve = [](const measure::Metrics& metrics) {
    return metrics.pve_face_mm ? metrics.pve_face_mm->mean : metrics.pve_mm.mean;
  };
  fmt::print(
      "{:<8} {:8.4f} {:8.4f} {:8.4f} {:+7.1f} % {:8.5f} {:8.5f} {:8.5f} {:7.3f} {:7.3f} {:7.3f} {:7.1f} % "
      "{:6.2f} {:6.3f}\n",
      who, alone, study::MergedPerson::mae(person.eyewear), merged, 100 * (merged / alone - 1),
      person.imu.mse, person.eyewear.mse, person.merged.mse, pve(person.imu), pve(person.eyewear),
      pve(person.merged), 100 * answered, person.hand_overs, person.confidence.expected_error());
}

Result<void> run_study_merged(StudyMergedOptions options) {
  MIEN_TRY_ASSIGN(options.rig, path_or(options.rig, "rigs/imu_eyewear.toml"));
  MIEN_TRY_ASSIGN(const study::MergedScene scene, read_scene(options));
  MIEN_TRY_ASSIGN(const std::vector<study::MergedPerson> people,
                  study::study_merged(options.request, scene, terminal_progress("merged")));
  clear_progress();
  if (options.json) {
    Json all = Json::array();
    for (const study::MergedPerson& person : people) all.push_back(to_json(person));
    print_json({{"rig", scene.rig.name},
                {"performers", options.request.performers},
                {"seconds", options.request.seconds},
                {"seed", options.request.seed},
                {"lost", options.request.lost},
                {"people", all}});
    return {};
  }
  fmt::print(
      "{} virtual people with IMUs and glasses, {:g} s, seed {}, {} IMUs lost\n\n{:<8} {:>26} {:>9} {:>26} "
      "{:>23} "
      "{:>9} {:>6} {:>6}\n{:<8} {:>8} {:>8} {:>8} {:>9} {:>8} {:>8} {:>8} {:>7} {:>7} {:>7} {:>9} {:>6} "
      "{:>6}\n",
      options.request.performers, options.request.seconds, options.request.seed, options.request.lost, "",
      "mean error", "", "MSE", "face mm", "glasses", "hands", "merged", "", "IMUs", "glasses", "merged",
      "against", "IMUs", "glasses", "merged", "IMUs", "glasses", "merged", "answer", "a s", "ECE");
  for (std::size_t p = 0; p < people.size(); ++p) print_row(fmt::format("{}", p + 1), people[p]);
  return {};
}

}  // namespace

void add_study_merged(Commands& commands, Command study) {
  auto options = std::make_shared<StudyMergedOptions>();
  const Command command = commands.add_under(
      study, "merged", "What IMUs and glasses worn together gain or lose against the IMUs alone",
      "mien study merged --performers 3 --seed 1", [options] { return run_study_merged(*options); });
  command.add_option("--rig", options->rig, "Rig of both kinds (default: rigs/imu_eyewear.toml)");
  command.add_option("--models", options->models,
                     "Folder with live.safetensors and eyewear.safetensors (default: models)");
  command.add_option("--performers", options->request.performers, "Virtual people")
      .in_range(1, 10000)
      .show_default();
  command
      .add_option("--seconds", options->request.seconds,
                  "Length of each one's performance after the prologue")
      .number_between(1.0, 3600.0)
      .show_default();
  command
      .add_option("--lost", options->request.lost,
                  "IMUs of the face, drawn for each person, that fall silent as the performance begins")
      .in_range(0, 1000)
      .show_default();
  add_seed_option(command, options->request.seed, "Of the people, their devices and what they do");
  command.add_flag("--json", options->json, "Print one JSON object");
}

}  // namespace mien::app
