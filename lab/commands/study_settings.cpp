#include "lab/commands/studies.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <tuple>
#include <utility>

#include "app/json_output.h"
#include "app/seed_option.h"
#include "lab/commands/output.h"
#include "lab/imu/settings_study.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"

namespace mien::lab {
namespace {

/// People whom no other study and no page reports: settings are chosen on the one seed and checked on the
/// other.
constexpr std::uint64_t kChoosing = 301, kChecking = 302;

/// Each setting `with` each value; of no values the default alone.
template <typename Settings, typename Value>
void vary(std::vector<Settings>& all, Value Settings::*member, const std::vector<double>& values) {
  if (values.empty()) return;
  std::vector<Settings> out;
  for (Settings one : all)
    for (const double value : values) {
      one.*member = static_cast<Value>(value);
      out.push_back(one);
    }
  all = std::move(out);
}

struct JitterOptions {
  JitterRequest request = {.seed = kChoosing};
  std::string model;
  std::string rig;
  std::vector<double> cutoff_hz, beta, speed_cutoff_hz, low_pass_hz, reference_noise, noise_gain;
  double limit = 0.65;
  Output to;
};

std::string name_of(const std::optional<tracker::JitterSettings>& settings) {
  if (!settings) return "none";
  std::string name = fmt::format("{:g}, {:g}, {:g}; {:g}; {:g}, {:g}", settings->cutoff_hz, settings->beta,
                                 settings->speed_cutoff_hz, settings->low_pass_hz, settings->reference_noise,
                                 settings->noise_gain);
  return *settings == tracker::JitterSettings{} ? name + " *" : name;
}

app::Json to_json(const FilteredFigures& profile) {
  return {{"mse", profile.mse},
          {"pve_mm", profile.pve_mm},
          {"jitter_ratio", profile.jitter_ratio},
          {"blink_f1", profile.blink_f1}};
}

app::Json to_json(const std::optional<tracker::JitterSettings>& settings) {
  if (!settings) return nullptr;
  return {{"cutoff_hz", settings->cutoff_hz},
          {"beta", settings->beta},
          {"speed_cutoff_hz", settings->speed_cutoff_hz},
          {"low_pass_hz", settings->low_pass_hz},
          {"reference_noise", settings->reference_noise},
          {"noise_gain", settings->noise_gain}};
}

const Columns<JitterTrial>& trial_columns() {
  using Trial = JitterTrial;
  static const Columns<Trial> columns = [] {
    Columns<Trial> out = {{"", "settings", "{}", [](const Trial& trial) { return name_of(trial.settings); }},
                          {"device", "", "", [](const Trial& trial) { return to_json(trial.device); }},
                          {"lab", "", "", [](const Trial& trial) { return to_json(trial.lab); }},
                          {"settings", "", "", [](const Trial& trial) { return to_json(trial.settings); }}};
    for (const auto& [name, profile] : {std::pair("device", &Trial::device), std::pair("lab", &Trial::lab)})
      for (const auto& [head, format, figure] :
           {std::tuple("MSE", "{:.5f}", &FilteredFigures::mse),
            std::tuple("PVE", "{:.3f}", &FilteredFigures::pve_mm),
            std::tuple("jitter", "{:.2f}", &FilteredFigures::jitter_ratio),
            std::tuple("F1", "{:.2f}", &FilteredFigures::blink_f1)})
        out.push_back({"", fmt::format("{}: {}", name, head), format,
                       [profile, figure](const Trial& trial) { return trial.*profile.*figure; }});
    return out;
  }();
  return columns;
}

Result<void> run_jitter(JitterOptions options) {
  MIEN_TRY_ASSIGN(options.rig, app::path_or(options.rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(options.model, app::path_or(options.model, "models/live.safetensors"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(options.rig));
  MIEN_TRY_ASSIGN(const model::ModelFile model, model::read_model(options.model));
  using tracker::JitterSettings;
  std::vector<JitterSettings> grid(1);
  vary(grid, &JitterSettings::cutoff_hz, options.cutoff_hz);
  vary(grid, &JitterSettings::beta, options.beta);
  vary(grid, &JitterSettings::speed_cutoff_hz, options.speed_cutoff_hz);
  vary(grid, &JitterSettings::low_pass_hz, options.low_pass_hz);
  vary(grid, &JitterSettings::reference_noise, options.reference_noise);
  vary(grid, &JitterSettings::noise_gain, options.noise_gain);
  std::vector<std::optional<JitterSettings>> filters = {std::nullopt};
  filters.insert(filters.end(), grid.begin(), grid.end());
  MIEN_TRY_ASSIGN(const std::vector<JitterTrial> chosen_on,
                  study_jitter(options.request, rig, model, filters, app::terminal_progress("jitter")));
  const std::optional<std::size_t> best = best_filter(chosen_on, options.limit);
  std::vector<std::optional<JitterSettings>> again = {std::nullopt, JitterSettings{}};
  if (best && chosen_on[*best].settings != again.back()) again.push_back(chosen_on[*best].settings);
  JitterRequest check = options.request;
  ++check.seed;
  MIEN_TRY_ASSIGN(const std::vector<JitterTrial> checked_on,
                  study_jitter(check, rig, model, again, app::terminal_progress("check")));
  app::Json out = {{"performers", options.request.performers},
                   {"seconds", options.request.seconds},
                   {"limit", options.limit},
                   {"best", best ? json_of(chosen_on[*best], trial_columns()) : app::Json()}};
  measure::Report report(
      "Settings of the jitter filter",
      fmt::format("{} people of {:g} s", options.request.performers, options.request.seconds));
  report.text("Cutoff, beta, speed's cutoff; low-pass; reference noise, gain (* the default).");
  for (const auto& [name, seed, trials] : {std::tuple("chosen_on", options.request.seed, &chosen_on),
                                           std::tuple("checked_on", check.seed, &checked_on)}) {
    out[name] = {{"seed", seed}, {"trials", json_of(*trials, trial_columns())}};
    report.table(table_of(fmt::format("{} seed {}", trials == &chosen_on ? "Chosen on" : "Checked on", seed),
                          *trials, trial_columns()));
  }
  report.text(best ? fmt::format("Best of at most {:g} of the truth's jitter: {}", options.limit,
                                 name_of(chosen_on[*best].settings))
                   : fmt::format("None leaves at most {:g} of the truth's jitter.", options.limit));
  return put_out(options.to, report, out);
}

/// How many people of each seed perform, and for how long.
template <class Request>
void add_people(const app::Command& command, Request& request) {
  command.add_option("--performers", request.performers, "Virtual people of each seed")
      .in_range(1, 10000)
      .show_default();
  command.add_option("--seconds", request.seconds, "Length of each performance after the prologue")
      .number_between(1.0, 3600.0)
      .show_default();
}

void add_jitter(app::Commands& commands, app::Command settings) {
  auto options = std::make_shared<JitterOptions>();
  const app::Command command = commands.add_under(
      settings, "jitter", "The live model's jitter filter: every combination of what is given",
      "mien study settings jitter --cutoff 0.2 0.4 0.8 --low-pass 5 7",
      [options] { return run_jitter(*options); });
  command.add_option("--model", options->model,
                     "Live model of facial IMUs (default: models/live.safetensors)");
  app::add_rig_option(command, options->rig);
  add_people(command, options->request);
  const auto values = [&](const char* name, std::vector<double>& into, const char* what, double least,
                          double most) { command.add_option(name, into, what).number_between(least, most); };
  values("--cutoff", options->cutoff_hz, "Cutoffs at rest, Hz", 1e-3, 30);
  values("--beta", options->beta, "Their growth, Hz per weight a second", 0, 1000);
  values("--speed-cutoff", options->speed_cutoff_hz, "Cutoffs of the speed, Hz", 1e-3, 30);
  values("--low-pass", options->low_pass_hz, "Cutoffs of the low-pass, Hz", 1e-3, 1000);
  values("--reference-noise", options->reference_noise, "Noise at which cutoffs are so: a third difference",
         1e-6, 1);
  values("--noise-gain", options->noise_gain, "Share by which the noise is followed each frame", 1e-4, 1);
  command.add_option("--limit", options->limit, "Most jitter in either profile, of the truth's own")
      .number_between(0.0, 1000.0)
      .show_default();
  app::add_seed_option(command, options->request.seed,
                       "Of the people to choose on; the next one's are checked on");
  app::add_json_flag(command, options->to.json);
}

struct DriftOptions {
  DriftRequest request = {.seed = kChoosing};
  std::string rig;
  std::vector<double> correlation_s, gate, heading_walk, creep_walk;
  Output to;
};

std::string name_of(const imu::DriftSettings& settings) {
  return fmt::format("{:g} s, {:g}; {:g}; {:g}", settings.correlation_s, settings.gate, settings.heading_walk,
                     settings.creep_walk);
}

const Columns<Drift>& drift_columns() {
  static const Columns<Drift> columns = {
      {"", "settings", "{}", [](const Drift& drift) { return name_of(drift.settings); }},
      {"correlation_s", "", "", [](const Drift& drift) { return drift.settings.correlation_s; }},
      {"gate", "", "", [](const Drift& drift) { return drift.settings.gate; }},
      {"heading_walk", "", "", [](const Drift& drift) { return drift.settings.heading_walk; }},
      {"creep_walk", "", "", [](const Drift& drift) { return drift.settings.creep_walk; }},
      {"rms_deg", "RMS, °", "{:.2f}", &Drift::rms_deg},
      {"vertical_rms_deg", "vertical, °", "{:.2f}", &Drift::vertical_rms_deg}};
  return columns;
}

Result<void> run_drift(DriftOptions options) {
  MIEN_TRY_ASSIGN(options.rig, app::path_or(options.rig, "rigs/default.toml"));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(options.rig));
  using imu::DriftSettings;
  std::vector<DriftSettings> grid(1);
  vary(grid, &DriftSettings::correlation_s, options.correlation_s);
  vary(grid, &DriftSettings::gate, options.gate);
  vary(grid, &DriftSettings::heading_walk, options.heading_walk);
  vary(grid, &DriftSettings::creep_walk, options.creep_walk);
  MIEN_TRY_ASSIGN(const std::vector<Drift> chosen_on,
                  study_drift(options.request, rig, grid, app::terminal_progress("drift")));
  const Drift& best = *std::ranges::min_element(chosen_on, {}, &Drift::rms_deg);
  DriftRequest check = options.request;
  ++check.seed;
  MIEN_TRY_ASSIGN(
      const std::vector<Drift> checked_on,
      study_drift(check, rig, std::vector{DriftSettings{}, best.settings}, app::terminal_progress("check")));
  const auto json = [](const Drift& drift) { return json_of(drift, drift_columns()); };
  measure::Report report(
      "Settings of the drift filter",
      fmt::format("{} people of {:g} s", options.request.performers, options.request.seconds));
  report.text("Correlation, gate; walks of headings and creep.");
  report.table(table_of(fmt::format("Chosen on seed {}", options.request.seed), chosen_on, drift_columns()));
  report.table(table_of(fmt::format("Checked on seed {}: the default, the best", check.seed), checked_on,
                        drift_columns()));
  return put_out(
      options.to, report,
      {{"performers", options.request.performers},
       {"seconds", options.request.seconds},
       {"chosen_on", {{"seed", options.request.seed}, {"trials", json_of(chosen_on, drift_columns())}}},
       {"best", json(best)},
       {"checked_on",
        {{"seed", check.seed}, {"default", json(checked_on.front())}, {"best", json(checked_on.back())}}}});
}

void add_drift(app::Commands& commands, app::Command settings) {
  auto options = std::make_shared<DriftOptions>();
  const app::Command command = commands.add_under(
      settings, "drift", "The drift filter: every combination of what is given, by the skin rotations' error",
      "mien study settings drift --correlation 30 60 120 --gate 2 2.5",
      [options] { return run_drift(*options); });
  app::add_rig_option(command, options->rig);
  add_people(command, options->request);
  const auto values = [&](const char* name, std::vector<double>& into, const char* what, double least,
                          double most) { command.add_option(name, into, what).number_between(least, most); };
  values("--correlation", options->correlation_s,
         "Seconds in which the skin gives one independent measurement", 0.02, 3600);
  values("--gate", options->gate, "Innovation gate, standard deviations", 0.1, 100);
  values("--heading", options->heading_walk, "Random walk of a heading, rad a root s", 0, 1);
  values("--creep", options->creep_walk, "Random walk of the adhesives' creep, rad a root s", 0, 1);
  app::add_seed_option(command, options->request.seed,
                       "Of the people to choose on; the next one's are checked on");
  app::add_json_flag(command, options->to.json);
}

}  // namespace

void add_study_settings(app::Commands& commands, app::Command study) {
  const app::Command settings = commands.add_under(
      study, "settings", "Chooses settings on virtual people whom no page reports, and checks them on others",
      "mien study settings jitter --cutoff 0.2 0.4 0.8", nullptr);
  settings.require_commands(0, 1);
  add_jitter(commands, settings);
  add_drift(commands, settings);
}

}  // namespace mien::lab
