#include "lab/commands/studies.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <numbers>

#include "app/chosen_face.h"
#include "app/command.h"
#include "app/json_output.h"
#include "app/seed_option.h"
#include "app/skin.h"
#include "lab/commands/study_ablation.h"
#include "lab/commands/study_confidence.h"
#include "lab/commands/study_headset.h"
#include "lab/commands/study_hours.h"
#include "lab/commands/study_live.h"
#include "lab/commands/study_loss.h"
#include "lab/commands/study_motion.h"
#include "lab/commands/study_placement.h"
#include "lab/commands/study_sensors.h"
#include "lab/commands/study_settings.h"
#include "lab/commands/study_speech.h"
#include "lab/commands/study_trackers.h"
#include "lab/imu/sensor_bound.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/imu/skin_site.h"

namespace mien::lab {
namespace {

Result<sensor::Rig> read_rig_or_default(const std::string& path) {
  MIEN_TRY_ASSIGN(const std::filesystem::path file, app::path_or(path, "rigs/default.toml"));
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
app::Json mean_or_null(const std::optional<measure::MeanStd>& value) {
  return value ? app::Json(value->mean) : app::Json();
}

Result<void> run_bound(const BoundOptions& options) {
  MIEN_TRY_ASSIGN(const sensor::Rig rig, read_rig_or_default(options.rig));
  MIEN_TRY_ASSIGN(const face::Face face, app::chosen_face(options.face));
  MIEN_TRY_ASSIGN(const std::vector<virt::SkinSite> all, virt::skin_sites(face, rig));
  std::vector<virt::SkinSite> sites;
  for (const std::uint16_t s : rig.face_sensors()) sites.push_back(all[s]);
  const measure::Meter meter(face);
  app::Json rows = app::Json::array();
  if (!options.json)
    fmt::print(
        "What {} sensors can see at best on {}: one frame of orientations, linear, independent "
        "shapes\n\n{:>6} {:>8} {:>8} "
        "{:>8} {:>8} {:>8}\n",
        sites.size(), options.face, "prior", "noise", "MSE", "PVE mm", "face mm", "LMK mm");
  for (const double prior : options.prior)
    for (const double noise_deg : options.noise_deg) {
      const SensorBound bound =
          sensor_bound(meter, sites, prior, noise_deg * std::numbers::pi / 180, Random(options.seed));
      if (!options.json)
        fmt::print("{:6.2f} {:6.1f}° {:8.4f} {:8.2f} {:>8} {:>8}\n", prior, noise_deg, bound.mse,
                   bound.pve_mm.mean, shown(bound.pve_face_mm), shown(bound.lmk_mm));
      app::Json left;
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
  if (options.json) app::print_json({{"face", options.face}, {"rig", rig.name}, {"rows", rows}});
  return {};
}

}  // namespace

void add_studies(app::Commands& commands) {
  const app::Command study =
      commands.add("study", "The experiments behind the numbers", "mien study bound --face builtin", nullptr);
  study.require_commands(0, 1);
  add_study_ablation(commands, study);
  add_study_confidence(commands, study);
  add_study_hours(commands, study);
  app::add_skin_command(commands, study);
  add_study_headset(commands, study);
  add_study_live(commands, study);
  add_study_loss(commands, study);
  add_study_motion(commands, study);
  add_study_placement(commands, study);
  add_study_sensors(commands, study);
  add_study_settings(commands, study);
  add_study_speech(commands, study);
  add_study_trackers(commands, study);
  auto bound = std::make_shared<BoundOptions>();
  const app::Command command = commands.add_under(
      study, "bound", "What a rig can see at best on a face, by theory",
      "mien study bound --face FaceXModel --noise 1", [bound] { return run_bound(*bound); });
  command.add_option("--face", bound->face, "As mien face takes it").show_default();
  app::add_rig_option(command, bound->rig);
  command.add_option("--prior", bound->prior, "Standard deviation of each weight beforehand")
      .number_between(1e-3, 10.0)
      .show_default();
  command.add_option("--noise", bound->noise_deg, "Noise of each orientation, degrees an axis")
      .number_between(1e-3, 90.0)
      .show_default();
  app::add_seed_option(command, bound->seed, "Of the draws that turn weight errors into millimetres");
  app::add_json_flag(command, bound->json);
}

}  // namespace mien::lab
