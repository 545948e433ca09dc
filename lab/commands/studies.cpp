#include "lab/commands/studies.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <numbers>

#include "app/chosen_face.h"
#include "app/command.h"
#include "app/seed_option.h"
#include "app/skin.h"
#include "lab/commands/output.h"
#include "lab/imu/sensor_bound.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/imu/skin_site.h"

namespace mien::lab {
namespace {

struct BoundOptions {
  std::string face = "builtin";
  std::string rig;
  std::vector<double> prior = {0.10, 0.15};
  std::vector<double> noise_deg = {0.3, 0.5, 1, 2, 3};
  std::uint64_t seed = 1;
  Output to;
};

/// The bound of one prior and one noise.
struct BoundRow {
  double prior = 0, noise_deg = 0;
  SensorBound bound;
};

const Columns<BoundRow>& bound_columns() {
  static const Columns<BoundRow> columns = {
      {"prior", "prior", "{:.2f}", &BoundRow::prior},
      {"noise_deg", "noise, °", "{:.1f}", &BoundRow::noise_deg},
      {"mse", "MSE", "{:.4f}", [](const BoundRow& row) { return row.bound.mse; }},
      {"pve_mm", "PVE mm", "{:.2f}", [](const BoundRow& row) { return row.bound.pve_mm.mean; }},
      {"pve_face_mm", "face mm", "{:.2f}",
       [](const BoundRow& row) { return or_null(optional_mean(row.bound.pve_face_mm)); }},
      {"lmk_mm", "LMK mm", "{:.2f}",
       [](const BoundRow& row) { return or_null(optional_mean(row.bound.lmk_mm)); }},
      {"left", "", "",
       [](const BoundRow& row) { return by_shape([&](std::size_t k) { return row.bound.left[k]; }); }}};
  return columns;
}

Result<void> run_bound(const BoundOptions& options) {
  MIEN_TRY_ASSIGN(const std::filesystem::path file, app::path_or(options.rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(file));
  MIEN_TRY_ASSIGN(const face::Face face, app::chosen_face(options.face));
  MIEN_TRY_ASSIGN(const std::vector<virt::SkinSite> all, virt::skin_sites(face, rig));
  std::vector<virt::SkinSite> sites;
  for (const std::uint16_t s : rig.face_sensors()) sites.push_back(all[s]);
  const measure::Meter meter(face);
  std::vector<BoundRow> rows;
  for (const double prior : options.prior)
    for (const double noise_deg : options.noise_deg)
      rows.push_back(
          {prior, noise_deg,
           sensor_bound(meter, sites, prior, noise_deg * std::numbers::pi / 180, Random(options.seed))});
  measure::Report report(fmt::format("What {} sensors can see at best", sites.size()),
                         "face " + options.face);
  report.table(table_of("One frame of orientations, linear, independent shapes", rows, bound_columns()));
  return put_out(options.to, report,
                 {{"face", options.face}, {"rig", rig.name}, {"rows", json_of(rows, bound_columns())}});
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
  app::add_json_flag(command, bound->to.json);
}

}  // namespace mien::lab
