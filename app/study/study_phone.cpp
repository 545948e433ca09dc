#include "app/study/study_phone.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <utility>

#include "app/command_line.h"
#include "app/json_output.h"
#include "app/performance.h"
#include "app/seed_option.h"
#include "mien/model/model_file.h"
#include "mien/study/imu/phone_study.h"

namespace mien::app {
namespace {

struct StudyPhoneOptions {
  study::PhoneStudyRequest request;
  std::string rig, model;
  std::vector<std::string> takes;
  bool json = false;
};

double middle(std::vector<double> values) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// Of the takes whose time was found.
struct SyncSummary {
  std::size_t found = 0;
  double median_ms = 0, worst_ms = 0, worst_drift_ppm = 0, within_one_sigma = 0;
};
SyncSummary summary_of(const std::vector<study::PhoneSyncRow>& rows) {
  SyncSummary out;
  std::vector<double> errors_ms;
  double within = 0;
  for (const study::PhoneSyncRow& row : rows) {
    if (row.refused) continue;
    ++out.found;
    errors_ms.push_back(1e3 * std::abs(row.error_s));
    out.worst_ms = std::max(out.worst_ms, errors_ms.back());
    out.worst_drift_ppm = std::max(out.worst_drift_ppm, std::abs(row.drift_error_ppm));
    if (std::abs(row.error_s) <= row.sigma_s) ++within;
  }
  out.median_ms = middle(errors_ms);
  if (out.found > 0) out.within_one_sigma = within / static_cast<double>(out.found);
  return out;
}

Json json_of(const study::PhoneSyncRow& row) {
  return {{"seed", row.seed},
          {"refused", row.refused ? Json(*row.refused) : Json()},
          {"error_ms", 1e3 * row.error_s},
          {"sigma_ms", 1e3 * row.sigma_s},
          {"drift_error_ppm", row.drift_error_ppm},
          {"drift_sigma_ppm", row.drift_sigma_ppm},
          {"agreement", row.agreement}};
}

Json json_of(const study::PhoneLearnRow& row) {
  return {{"who", row.who},
          {"devices", row.devices},
          {"learnt_s", row.learnt_s},
          {"refused", row.refused ? Json(*row.refused) : Json()},
          {"taken", row.taken},
          {"pve_before_mm", row.all.pve_before_mm},
          {"pve_after_mm", row.all.pve_after_mm},
          {"mse_before", row.all.mse_before},
          {"mse_after", row.all.mse_after},
          {"mse_lost_before", row.mse_lost_before},
          {"mse_lost_after", row.mse_lost_after},
          {"worst_lost", row.worst_lost},
          {"pve_perfect_mm", row.pve_perfect_mm ? Json(*row.pve_perfect_mm) : Json()}};
}

Json json_of(const auto& rows) {
  Json all = Json::array();
  for (const auto& row : rows) all.push_back(json_of(row));
  return all;
}

double percent(double after, double before) {
  return before > 0 ? 100 * (after / before - 1) : 0;
}

void print(const std::vector<study::PhoneSyncRow>& rows) {
  fmt::print("| seed | error ms | stated sigma ms | drift error ppm | stated sigma ppm | agreement |\n");
  fmt::print("|---|---|---|---|---|---|\n");
  for (const study::PhoneSyncRow& row : rows)
    if (row.refused)
      fmt::print("| {} | refused: {} | | | | |\n", row.seed, *row.refused);
    else
      fmt::print("| {} | {:+.1f} | {:.1f} | {:+.0f} | {:.0f} | {:.2f} |\n", row.seed, 1e3 * row.error_s,
                 1e3 * row.sigma_s, row.drift_error_ppm, row.drift_sigma_ppm, row.agreement);
  const SyncSummary all = summary_of(rows);
  fmt::print(
      "\n{} of {} found: median {:.1f} ms, worst {:.1f} ms, drift at most {:.0f} ppm off; {:.0f} % within "
      "one "
      "sigma\n\n",
      all.found, rows.size(), all.median_ms, all.worst_ms, all.worst_drift_ppm, 100 * all.within_one_sigma);
}

void print(const std::vector<study::PhoneLearnRow>& rows) {
  fmt::print(
      "| who | devices | learnt s | PVE mm before | after | | squared error | one sensor lost | worst | of a "
      "perfect phone mm |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|---|\n");
  for (const study::PhoneLearnRow& row : rows) {
    if (row.refused) {
      fmt::print("| {} | {} | {:.0f} | refused: {} | | | | | | |\n", row.who, row.devices, row.learnt_s,
                 *row.refused);
      continue;
    }
    fmt::print("| {} | {} | {:.0f} | {:.3f} | {:.3f}{} | {:+.0f} % | {:+.0f} % | ", row.who, row.devices,
               row.learnt_s, row.all.pve_before_mm, row.all.pve_after_mm, row.taken ? "" : " (not taken)",
               percent(row.all.pve_after_mm, row.all.pve_before_mm),
               percent(row.all.mse_after, row.all.mse_before));
    if (row.mse_lost_before > 0)
      fmt::print("{:+.0f} % | {:+.0f} % | ", percent(row.mse_lost_after, row.mse_lost_before),
                 100 * (row.worst_lost - 1));
    else
      fmt::print("| | ");
    fmt::print("{} |\n", row.pve_perfect_mm ? fmt::format("{:.3f}", *row.pve_perfect_mm) : "");
  }
  fmt::print("\n");
}

Result<void> run_study_phone(StudyPhoneOptions options) {
  study::PhoneStudyRequest& request = options.request;
  MIEN_TRY_ASSIGN(request.rig, path_or(options.rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(options.model, path_or(options.model, "models/live.safetensors"));
  MIEN_TRY_ASSIGN(request.model, model::read_model(options.model));
  for (const std::string& path : options.takes) {
    std::error_code code;
    if (!std::filesystem::exists(path, code)) {
      fmt::print(stderr, "mien: {} is not here: its rows are left out\n", path);
      continue;
    }
    MIEN_TRY_ASSIGN(Performance performance, load_performance(path));
    request.motions.push_back(std::move(performance.motion));
  }
  MIEN_TRY_ASSIGN(const study::PhoneStudy study, study::study_phone(request, terminal_progress("phone")));
  clear_progress();
  if (options.json) {
    const SyncSummary all = summary_of(study.sync);
    print_json({{"sync", json_of(study.sync)},
                {"sync_found", all.found},
                {"sync_median_ms", all.median_ms},
                {"sync_worst_ms", all.worst_ms},
                {"sync_worst_drift_ppm", all.worst_drift_ppm},
                {"sync_within_one_sigma", all.within_one_sigma},
                {"learnt", json_of(study.learnt)},
                {"curve", json_of(study.curve)}});
    return {};
  }
  if (!study.sync.empty()) print(study.sync);
  if (!study.learnt.empty()) print(study.learnt);
  if (!study.curve.empty()) print(study.curve);
  return {};
}

}  // namespace

void add_study_phone(Commands& commands, Command study) {
  auto options = std::make_shared<StudyPhoneOptions>();
  const Command command = commands.add_under(study, "phone",
                                             "A phone beside IMUs: how well its time is found, and what a "
                                             "live model that learns a wearer from it gains on "
                                             "another day",
                                             "mien study phone --takes a.csv b.csv --curve 15 30 60 120 300",
                                             [options] { return run_study_phone(*options); });
  study::PhoneStudyRequest& request = options->request;
  command.add_option("--seeds", request.sync_seeds, "Virtual takes whose time is found")
      .in_range(std::size_t{0}, std::size_t{1000})
      .show_default();
  command.add_option("--seconds", request.sync_s, "Of each of these")
      .number_between(20.0, 3600.0)
      .show_default();
  command.add_option("--strangers", request.strangers, "Virtual wearers who are learnt")
      .in_range(std::size_t{0}, std::size_t{1000})
      .show_default();
  command
      .add_option("--stranger-seconds", request.stranger_s,
                  "Of each of these: the first half is learnt, the second tried with sensors put on anew")
      .number_between(30.0, 3600.0)
      .show_default();
  command.add_option("--curve", request.curve_s,
                     "Also learn from so many seconds, from the first two strangers");
  command.add_option("--takes", options->takes,
                     "Recorded performances, learnt and tried in the same way: Live Link CSVs");
  command.add_option("--face", request.face, "On which these are performed").show_default();
  command.add_option("--rig", options->rig, "Rig file (default: rigs/default.toml)");
  command.add_option("--model", options->model, "A live model (default: models/live.safetensors)");
  add_seed_option(command, request.seed, "Of all that is drawn");
  command.add_flag("--json", options->json, "Print one JSON object");
}

}  // namespace mien::app
