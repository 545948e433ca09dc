#include "lab/commands/study_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <tuple>
#include <utility>

#include "app/json_output.h"
#include "app/seed_option.h"
#include "lab/imu/drift.h"
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
  bool json = false;
};

std::string name_of(const std::optional<tracker::JitterSettings>& settings) {
  if (!settings) return "none";
  std::string name = fmt::format("{:g}, {:g}, {:g}; {:g}; {:g}, {:g}", settings->cutoff_hz, settings->beta,
                                 settings->speed_cutoff_hz, settings->low_pass_hz, settings->reference_noise,
                                 settings->noise_gain);
  return *settings == tracker::JitterSettings{} ? name + " *" : name;
}

void print_trial(const JitterTrial& trial) {
  fmt::print("{:<38}", name_of(trial.settings));
  for (const FilteredFigures* profile : {&trial.device, &trial.lab})
    fmt::print(" {:9.5f} {:6.3f} {:6.2f} {:5.2f}", profile->mse, profile->pve_mm, profile->jitter_ratio,
               profile->blink_f1);
  fmt::print("\n");
}

app::Json to_json(const FilteredFigures& profile) {
  return {{"mse", profile.mse},
          {"pve_mm", profile.pve_mm},
          {"jitter_ratio", profile.jitter_ratio},
          {"blink_f1", profile.blink_f1}};
}

app::Json to_json(const JitterTrial& trial) {
  app::Json out = {{"device", to_json(trial.device)}, {"lab", to_json(trial.lab)}, {"settings", nullptr}};
  if (trial.settings)
    out["settings"] = {{"cutoff_hz", trial.settings->cutoff_hz},
                       {"beta", trial.settings->beta},
                       {"speed_cutoff_hz", trial.settings->speed_cutoff_hz},
                       {"low_pass_hz", trial.settings->low_pass_hz},
                       {"reference_noise", trial.settings->reference_noise},
                       {"noise_gain", trial.settings->noise_gain}};
  return out;
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
  app::clear_progress();
  if (options.json) {
    app::Json out = {{"performers", options.request.performers},
                     {"seconds", options.request.seconds},
                     {"limit", options.limit},
                     {"best", best ? to_json(chosen_on[*best]) : app::Json()}};
    for (const auto& [name, seed, trials] : {std::tuple("chosen_on", options.request.seed, &chosen_on),
                                             std::tuple("checked_on", check.seed, &checked_on)}) {
      out[name] = {{"seed", seed}, {"trials", app::Json::array()}};
      for (const JitterTrial& trial : *trials) out[name]["trials"].push_back(to_json(trial));
    }
    app::print_json(out);
    return {};
  }
  fmt::print(
      "Cutoff, beta, speed's cutoff; low-pass; reference noise, gain (* the default); {} people of {:g} s\n\n"
      "{:<38} {:^29} {:^29}\n{:<38} {:>9} {:>6} {:>6} {:>5} {:>9} {:>6} {:>6} {:>5}\n",
      options.request.performers, options.request.seconds, "", "device", "lab",
      fmt::format("chosen on seed {}", options.request.seed), "MSE", "PVE", "jitter", "F1", "MSE", "PVE",
      "jitter", "F1");
  for (const JitterTrial& trial : chosen_on) print_trial(trial);
  if (best)
    fmt::print("\nbest of at most {:g} of the truth's jitter: {}\n", options.limit,
               name_of(chosen_on[*best].settings));
  else
    fmt::print("\nnone leaves at most {:g} of the truth's jitter\n", options.limit);
  fmt::print("\nchecked on seed {}\n", check.seed);
  for (const JitterTrial& trial : checked_on) print_trial(trial);
  return {};
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
  app::add_json_flag(command, options->json);
}

struct DriftOptions {
  DriftRequest request = {.seed = kChoosing};
  std::string rig;
  std::vector<double> correlation_s, gate, heading_walk, creep_walk;
  bool json = false;
};

std::string name_of(const imu::DriftSettings& settings) {
  return fmt::format("{:g} s, {:g}; {:g}; {:g}", settings.correlation_s, settings.gate, settings.heading_walk,
                     settings.creep_walk);
}

app::Json to_json(const Drift& drift) {
  return {{"correlation_s", drift.settings.correlation_s},
          {"gate", drift.settings.gate},
          {"heading_walk", drift.settings.heading_walk},
          {"creep_walk", drift.settings.creep_walk},
          {"rms_deg", drift.rms_deg},
          {"vertical_rms_deg", drift.vertical_rms_deg}};
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
  app::clear_progress();
  if (options.json) {
    app::Json trials = app::Json::array();
    for (const Drift& drift : chosen_on) trials.push_back(to_json(drift));
    app::print_json({{"performers", options.request.performers},
                     {"seconds", options.request.seconds},
                     {"chosen_on", {{"seed", options.request.seed}, {"trials", trials}}},
                     {"best", to_json(best)},
                     {"checked_on",
                      {{"seed", check.seed},
                       {"default", to_json(checked_on.front())},
                       {"best", to_json(checked_on.back())}}}});
    return {};
  }
  const auto print = [](const std::string& name, const Drift& drift) {
    fmt::print("{:<38} {:6.2f}° {:6.2f}°\n", name, drift.rms_deg, drift.vertical_rms_deg);
  };
  fmt::print("Correlation, gate; walks of headings and creep; {} people of {:g} s\n\n{:<38} {:>7} {:>7}\n",
             options.request.performers, options.request.seconds,
             fmt::format("chosen on seed {}", options.request.seed), "RMS", "vert.");
  for (const Drift& drift : chosen_on) print(name_of(drift.settings), drift);
  fmt::print("\nbest: {}\n\nchecked on seed {}\n", name_of(best.settings), check.seed);
  print("default", checked_on.front());
  print("best", checked_on.back());
  return {};
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
  app::add_json_flag(command, options->json);
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
