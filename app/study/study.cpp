#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <numbers>

#include "app/chosen_face.h"
#include "app/command.h"
#include "app/json_output.h"
#include "app/seed_option.h"
#include "app/study/study_ablation.h"
#include "app/study/study_confidence.h"
#include "app/study/study_hand.h"
#include "app/study/study_headset.h"
#include "app/study/study_hours.h"
#include "app/study/study_lag.h"
#include "app/study/study_live.h"
#include "app/study/study_loss.h"
#include "app/study/study_lost.h"
#include "app/study/study_merged.h"
#include "app/study/study_motion.h"
#include "app/study/study_phone.h"
#include "app/study/study_placement.h"
#include "app/study/study_resting.h"
#include "app/study/study_sensors.h"
#include "app/study/study_settings.h"
#include "app/study/study_speech.h"
#include "app/study/study_trackers.h"
#include "mien/sensor/rig.h"
#include "mien/study/imu/sensor_bound.h"
#include "mien/study/imu/skin_motion.h"

namespace mien::app {
namespace {

Result<sensor::Rig> read_rig_or_default(const std::string& path) {
  MIEN_TRY_ASSIGN(const std::filesystem::path file, path_or(path, "rigs/default.toml"));
  return sensor::read_rig(file);
}

struct BoundOptions {
  std::string face = "builtin";
  std::string rig;
  std::vector<double> prior = {0.10, 0.15};
  std::vector<double> noise_deg = {0.3, 0.5, 1, 2, 3};
  std::uint64_t seed = 1;
  bool json = false;
};

/// What a face without regions or landmarks does not have is shown as missing, not as zero.
std::string shown(const std::optional<measure::MeanStd>& value) {
  return value ? fmt::format("{:.2f}", value->mean) : "-";
}
Json mean_or_null(const std::optional<measure::MeanStd>& value) {
  return value ? Json(value->mean) : Json();
}

Result<void> run_bound(const BoundOptions& options) {
  MIEN_TRY_ASSIGN(const sensor::Rig rig, read_rig_or_default(options.rig));
  MIEN_TRY_ASSIGN(const face::Face face, chosen_face(options.face));
  MIEN_TRY_ASSIGN(const std::vector<virt::SkinSite> all, virt::skin_sites(face, rig));
  std::vector<virt::SkinSite> sites;
  for (const std::uint16_t s : rig.face_sensors()) sites.push_back(all[s]);
  const measure::Meter meter(face);
  Json rows = Json::array();
  if (!options.json)
    fmt::print(
        "What {} sensors can see at best on {}: one frame of orientations, linear, independent "
        "shapes\n\n{:>6} {:>8} {:>8} "
        "{:>8} {:>8} {:>8}\n",
        sites.size(), options.face, "prior", "noise", "MSE", "PVE mm", "face mm", "LMK mm");
  for (const double prior : options.prior)
    for (const double noise_deg : options.noise_deg) {
      const study::SensorBound bound =
          study::sensor_bound(meter, sites, prior, noise_deg * std::numbers::pi / 180, Random(options.seed));
      if (!options.json)
        fmt::print("{:6.2f} {:6.1f}° {:8.4f} {:8.2f} {:>8} {:>8}\n", prior, noise_deg, bound.mse,
                   bound.pve_mm.mean, shown(bound.pve_face_mm), shown(bound.lmk_mm));
      Json left;
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        left[std::string(face::kShapeNames[k])] = bound.left[k];
      rows.push_back({{"prior", prior},
                      {"noise_deg", noise_deg},
                      {"mse", bound.mse},
                      {"pve_mm", bound.pve_mm.mean},
                      {"pve_face_mm", mean_or_null(bound.pve_face_mm)},
                      {"lmk_mm", mean_or_null(bound.lmk_mm)},
                      {"left", left}});
    }
  if (options.json) print_json({{"face", options.face}, {"rig", rig.name}, {"rows", rows}});
  return {};
}

struct SkinOptions {
  study::SkinMotionRequest request;
  std::string rig;
};

Result<void> run_skin(const SkinOptions& options) {
  MIEN_TRY_ASSIGN(const sensor::Rig rig, read_rig_or_default(options.rig));
  MIEN_TRY_ASSIGN(const sensor::SkinMotion skin,
                  study::study_skin_motion(options.request, rig, terminal_progress("skin")));
  fmt::print("{}", sensor::write_skin(skin));
  return {};
}

void add_skin(Commands& commands, Command study) {
  auto skin = std::make_shared<SkinOptions>();
  const Command command =
      commands.add_under(study, "skin", "How skin turns under a rig's sensors: the [skin] table of its file",
                         "mien study skin --rig my_rig.toml > skin.toml", [skin] { return run_skin(*skin); });
  command.add_option("--rig", skin->rig, "Rig file (default: rigs/default.toml)");
  command.add_option("--performers", skin->request.performers, "Virtual performers")
      .in_range(1, 100000)
      .show_default();
  command.add_option("--seconds", skin->request.seconds, "Length of each performance")
      .number_between(1.0, 3600.0)
      .show_default();
  add_seed_option(command, skin->request.seed, "Of the performers");
}

}  // namespace

void add_study_command(Commands& commands) {
  const Command study =
      commands.add("study", "The experiments behind the numbers", "mien study bound --face builtin", nullptr);
  study.require_commands(0, 1);
  add_study_ablation(commands, study);
  add_study_confidence(commands, study);
  add_study_hours(commands, study);
  add_skin(commands, study);
  add_study_hand(commands, study);
  add_study_headset(commands, study);
  add_study_lag(commands, study);
  add_study_live(commands, study);
  add_study_loss(commands, study);
  add_study_phone(commands, study);
  add_study_lost(commands, study);
  add_study_merged(commands, study);
  add_study_motion(commands, study);
  add_study_placement(commands, study);
  add_study_resting(commands, study);
  add_study_sensors(commands, study);
  add_study_settings(commands, study);
  add_study_speech(commands, study);
  add_study_trackers(commands, study);
  auto bound = std::make_shared<BoundOptions>();
  const Command command = commands.add_under(
      study, "bound", "What a rig can see at best on a face, by theory",
      "mien study bound --face FaceXModel --noise 1", [bound] { return run_bound(*bound); });
  command.add_option("--face", bound->face, "As mien face takes it").show_default();
  command.add_option("--rig", bound->rig, "Rig file (default: rigs/default.toml)");
  command.add_option("--prior", bound->prior, "Standard deviation of each weight beforehand")
      .number_between(1e-3, 10.0)
      .show_default();
  command.add_option("--noise", bound->noise_deg, "Noise of each orientation, degrees an axis")
      .number_between(1e-3, 90.0)
      .show_default();
  add_seed_option(command, bound->seed, "Of the draws that turn weight errors into millimetres");
  command.add_flag("--json", bound->json, "Print one JSON object");
}

}  // namespace mien::app
