#include <fmt/format.h>

#include <memory>
#include <numbers>

#include "app/command.h"
#include "app/json_output.h"
#include "mien/core/files.h"
#include "mien/face/load.h"
#include "mien/sensor/rig.h"
#include "mien/study/sensor_bound.h"

namespace mien::app {
namespace {

struct BoundOptions {
  std::string face = "builtin";
  std::string rig;
  std::vector<double> prior = {0.10, 0.15};
  std::vector<double> noise_deg = {0.3, 0.5, 1, 2, 3};
  std::uint64_t seed = 1;
  bool json = false;
};

Result<void> run_bound(BoundOptions options) {
  if (options.rig.empty()) {
    MIEN_TRY_ASSIGN(options.rig, find_resource("rigs/default.toml"));
  }
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(options.rig));
  MIEN_TRY_ASSIGN(const face::Face face, face::load_face(options.face));
  MIEN_TRY_ASSIGN(const std::vector<virt::SkinSite> all, virt::skin_sites(face, rig));
  std::vector<virt::SkinSite> sites;
  for (const std::uint16_t s : rig.face_sensors()) sites.push_back(all[s]);
  const study::Meter meter(face);
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
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
      const double face_mm = bound.pve_face_mm ? bound.pve_face_mm->mean : 0;
      const double lmk_mm = bound.lmk_mm ? bound.lmk_mm->mean : 0;
      if (!options.json)
        fmt::print("{:6.2f} {:6.1f}° {:8.4f} {:8.2f} {:8.2f} {:8.2f}\n", prior, noise_deg, bound.mse,
                   bound.pve_mm.mean, face_mm, lmk_mm);
      nlohmann::ordered_json left;
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        left[std::string(face::kShapeNames[k])] = bound.left[k];
      rows.push_back({{"prior", prior},
                      {"noise_deg", noise_deg},
                      {"mse", bound.mse},
                      {"pve_mm", bound.pve_mm.mean},
                      {"pve_face_mm", face_mm},
                      {"lmk_mm", lmk_mm},
                      {"left", left}});
    }
  if (options.json) print_json({{"face", options.face}, {"rig", rig.name}, {"rows", rows}});
  return {};
}

}  // namespace

void add_study_command(Commands& commands) {
  CLI::App* study =
      commands.add("study", "The experiments behind the numbers", "mien study bound --face builtin", nullptr);
  study->require_subcommand(0, 1);
  auto bound = std::make_shared<BoundOptions>();
  CLI::App* command = commands.add_under(study, "bound", "What a rig can see at best on a face, by theory",
                                         "mien study bound --face FaceXModel --noise 1",
                                         [bound] { return run_bound(*bound); });
  command->add_option("--face", bound->face, "As mien face takes it")->capture_default_str();
  command->add_option("--rig", bound->rig, "Rig file (default: rigs/default.toml)");
  command->add_option("--prior", bound->prior, "Standard deviation of each weight beforehand")
      ->check(number_between(1e-3, 10.0))
      ->capture_default_str();
  command->add_option("--noise", bound->noise_deg, "Noise of each orientation, degrees an axis")
      ->check(number_between(1e-3, 90.0))
      ->capture_default_str();
  command->add_option("--seed", bound->seed, "Of the draws that turn weight errors into millimetres")
      ->capture_default_str();
  command->add_flag("--json", bound->json, "Print one JSON object");
}

}  // namespace mien::app
