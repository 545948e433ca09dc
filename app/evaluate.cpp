#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "app/chosen_face.h"
#include "app/command.h"
#include "app/model_option.h"
#include "app/phone_option.h"
#include "app/private_folder.h"
#include "app/wear_again.h"
#include "mien/core/excerpt.h"
#include "mien/measure/evaluation_json.h"
#include "mien/measure/evaluation_report.h"
#include "mien/modalities/modalities.h"
#include "mien/sensor/rig_part.h"
#include "mien/solve/part_of_work.h"
#include "mien/solve/phone_truth.h"
#include "mien/solve/region_tally.h"
#include "mien/solve/solve.h"
#include "mien/solve/trace_features.h"

namespace mien::app {
namespace {

struct EvaluateOptions {
  std::vector<std::string> takes;
  ModelOption model;
  ShapingOption shaping;
  PhoneOption phone;  // Not given: the takes' own truth.
  bool ablate = false;
  bool blink = false;
  double every_min = 0;
  int wears = 0;
  std::string face;
  std::string report;
  bool no_adapt = false;
  bool json = false;
};

void print_row(const char* name, const measure::Metrics& m) {
  const auto mean = [](const std::optional<measure::MeanStd>& value) {
    return value ? fmt::format("{:.3f}", value->mean) : "-";
  };
  const auto ratio = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.2f}", *value) : "-";
  };
  fmt::print("{:<13} {:7.3f} {:>7} {:>7} {:8.4f} {:9.4f} {:>7} {:>8}\n", name, m.pve_mm.mean,
             mean(m.pve_face_mm), mean(m.lmk_mm), m.mse, m.mse_observed, ratio(m.jitter_ratio),
             ratio(m.blink_f1));
}

void print_pieces(const measure::TakePieces& of) {
  fmt::print("\n{}\n{:>7} {:>8} {:>9} {:>6}  {}\n", one_line(of.take), "minute", "MSE", "mean pose", "ratio",
             "bias, less the first piece's");
  for (const measure::Piece& piece : of.pieces) {
    const std::string bias =
        piece.biased_shape ? fmt::format("{} {:+.2f}", face::kShapeNames[*piece.biased_shape], piece.bias)
                           : "-";
    fmt::print("{:7.1f} {:8.4f} {:9.4f} {:6.2f}  {}\n", piece.begin_s / 60, piece.mse, piece.mean_pose_mse,
               piece.ratio, bias);
  }
}

using Track = std::vector<face::BlendshapeWeights>;

Track weights_of(const solve::Solution& solution) {
  Track out;
  out.reserve(solution.frames.size());
  for (const face::OutputFrame& frame : solution.frames) out.push_back(frame.weights);
  return out;
}

/// Settings without one of their steps.
struct Ablated {
  std::string without;  ///< The step's name; "every step".
  shaping::ShaperSettings settings;
};

/// `settings` with one more step left out each, in the order of the chain; last with none of them. Blinks are
/// in none.
std::vector<Ablated> ablations(const shaping::ShaperSettings& settings) {
  std::vector<Ablated> out;
  for (std::size_t step = 0; step < shaping::kChainStepCount; ++step) {
    if (step == static_cast<std::size_t>(shaping::ChainStep::blinks)) continue;
    out.push_back({std::string(shaping::kChainStepNames[step]), settings});
    out.back().settings.off.set(step);
  }
  out.push_back({"every step", settings});
  out.back().settings.off.set();
  return out;
}

/// How an answer that is measured is shaped: without made blinks, which are no answer to sensors. A window
/// model's own answer stays as it is where nothing is asked for.
OpenModel::Shaping measured_shaping(OpenModel::Shaping asked, const OpenModel& model, bool ablate) {
  if (!asked && (ablate || model.steps() == 0)) asked.emplace();
  if (asked) asked->blinks_per_min = 0;
  return asked;
}

/// The face that `name` asks for; where it asks for none, the one on which all the takes were performed, or
/// the built-in one where that is not on this machine. `name` becomes the one that it is.
Result<face::Face> face_to_measure_on(const std::set<std::string>& performed_on, std::string& name) {
  if (!name.empty()) return chosen_face(name);
  std::vector<std::string> shown;
  for (const std::string& one : performed_on) shown.push_back(excerpt(one));
  if (performed_on.size() > 1)
    return fail(ErrorCode::bad_usage,
                fmt::format("the takes were performed on different faces ({})", fmt::join(shown, ", ")),
                "evaluate", "evaluate them apart, or name one face for all with --face");
  name = *performed_on.begin();
  auto face = chosen_face(name);
  if (face || face.error().code != ErrorCode::not_found) return face;
  fmt::print(stderr,
             "mien: the take's face {} is not here: measured on the built-in one; --face names another\n",
             one_line(name));
  name = "builtin";
  return chosen_face(name);
}

/// What a take is measured against.
struct Truth {
  std::vector<take::TruthFrame> frames;
  std::optional<measure::ToldTruth> told;  ///< None: the take's own.
};

Result<std::vector<take::TruthFrame>> own_truth(const take::Take& take) {
  auto own = solve::own_truth(take);
  // What a phone told can be asked for where its time can be found.
  if (!own && own.error().code == ErrorCode::not_found && check_aligns(take))
    own.error().fix += sensor::truths_of(take.rig()).empty()
                           ? ", or name what a phone recorded meanwhile (--truth FILE.csv)"
                           : ", or measure against the phone that looked on (--truth phone)";
  return own;
}

/// Of a phone it says on stderr what align says.
Result<Truth> read_truth(const PhoneOption& phone, const take::Take& take) {
  if (!phone.given()) {
    MIEN_TRY_ASSIGN(std::vector<take::TruthFrame> own, own_truth(take));
    return Truth{.frames = std::move(own), .told = {}};
  }
  MIEN_TRY(check_aligns(take));
  MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> features, solve::take_features(take));
  MIEN_TRY_ASSIGN(const solve::PhoneTrack track, phone.open(take, features));
  MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
  auto truth = solve::phone_truth(events, features, track);
  if (!truth) {
    truth.error().where = take.path().string();
    return std::unexpected(std::move(truth).error());
  }
  const auto known = std::ranges::count_if(truth->frames, &take::TruthFrame::evaluated);
  const phone::TimeAlignment& at = truth->alignment;
  const std::string file = std::filesystem::path(phone.file()).filename().string();
  return Truth{.frames = std::move(truth->frames),
               .told = measure::ToldTruth{.take = take.path().string(),
                                          .by = file.empty() ? track.motion.name : file,
                                          .agreement = at.agreement,
                                          .offset_ms = 1e3 * at.offset_s,
                                          .offset_sigma_ms = 1e3 * at.offset_sigma_s,
                                          .known_s = static_cast<double>(known) / kFrameRateHz,
                                          .rest_known = truth->rest.has_value()}};
}

/// Says of each reason for which a wearer was not learnt, why: `takes` are those that it holds of.
void say_unlearnt(const std::map<std::string, std::vector<std::string>>& unlearnt) {
  for (const auto& [why, takes] : unlearnt) {
    const std::string more = takes.size() > 1 ? fmt::format(" and {} more", takes.size() - 1) : "";
    fmt::print(stderr, "mien: {}{}: the wearer was not learnt: {}\n", without_controls(takes.front()), more,
               without_controls(why));
  }
}

/// The takes performed anew, over so many wears of the sensors.
Result<measure::Wears> measure_wears(int wears, const std::vector<take::Take>& takes, const OpenModel& model,
                                     const OpenModel::Shaping& shaping, const measure::Meter& meter) {
  MIEN_TRY_ASSIGN(const PrivateFolder folder, PrivateFolder::make());
  const Progress shown = terminal_progress("wears");
  std::vector<measure::Evaluation> evaluations;
  for (int wear = 1; wear <= wears; ++wear) {
    std::vector<measure::TakeEstimates> estimates;
    const Progress part = solve::part_of_work(shown, (wear - 1.0) / wears, 1.0 * wear / wears);
    for (const take::Take& take : takes) {
      const std::uint64_t seed = take.header().seed + static_cast<std::uint64_t>(wear);
      MIEN_TRY_ASSIGN(const take::Take anew, wear_again(take, seed, folder.path(), part));
      MIEN_TRY_ASSIGN(const std::vector<solve::Solution> solutions,
                      model.solve_by_each(anew, fmt::format("wear {}", wear), {&shaping, 1}));
      MIEN_TRY_ASSIGN(const std::vector<take::TruthFrame> truth, solve::own_truth(anew));
      estimates.push_back(solve::with_truth(take.path().string(), solutions.front(), truth));
    }
    MIEN_TRY_ASSIGN(evaluations.emplace_back(), measure::evaluate(meter, estimates, model.mean_pose()));
  }
  return measure::over_wears(evaluations);
}

Result<void> run_evaluate(EvaluateOptions options) {
  if (!options.report.empty()) MIEN_TRY(check_output(options.report, {".html"}));
  if (!options.phone.file().empty() && options.takes.size() > 1)
    return fail(ErrorCode::bad_usage, "a phone's file belongs to one take",
                "--truth " + options.phone.truth(), "evaluate the takes apart");
  std::vector<take::Take> takes;
  std::vector<std::vector<take::TruthFrame>> truths;  // Of each take.
  std::vector<measure::ToldTruth> told;
  std::set<std::string> devices;
  std::set<std::string> performed_on, performed;
  for (const std::string& path : options.takes) {
    MIEN_TRY_ASSIGN(take::Take take, take::Take::open(path));
    MIEN_TRY_ASSIGN(Truth truth, read_truth(options.phone, take));
    truths.push_back(std::move(truth.frames));
    if (truth.told) told.push_back(*std::move(truth.told));
    if (options.wears > 0) MIEN_TRY(check_wears_again(take));
    devices.insert(take.header().devices);
    performed_on.insert(take.header().face);
    performed.insert(take.header().script);
    takes.push_back(std::move(take));
  }
  for (const take::Take& take : takes)
    if (modalities::has_window_models(take.rig()) != modalities::has_window_models(takes.front().rig()))
      return fail(ErrorCode::bad_usage, "the takes are of sensors that no one model knows",
                  take.path().string(), "evaluate them apart");
  MIEN_TRY_ASSIGN(const OpenModel::Shaping asked, options.shaping.read());
  // Of a session's take the prompts may lie among what a phone's truth is known of.
  options.model.adapt = !options.no_adapt && !options.phone.given();
  MIEN_TRY_ASSIGN(const OpenModel model, options.model.open(takes.front().rig()));
  if (options.blink && model.steps() > 0 && !asked)
    return fail(ErrorCode::bad_usage, "a window model's answer is shown as it is, without blinks", "--blink",
                "leave it away, or shape the answer with --shaping");
  const OpenModel::Shaping shaping = measured_shaping(asked, model, options.ablate);
  std::string face_name = options.face;
  MIEN_TRY_ASSIGN(const face::Face face, face_to_measure_on(performed_on, face_name));
  std::vector<measure::TakeEstimates> estimates;
  const std::vector<Ablated> ablated = options.ablate ? ablations(*shaping) : std::vector<Ablated>{};
  std::vector<OpenModel::Shaping> all = {shaping};
  for (const Ablated& one : ablated) all.emplace_back(one.settings);
  if (options.blink) all.emplace_back(asked.value_or(shaping::ShaperSettings{}));
  std::vector<std::vector<Track>> others(all.size() - 1);  // Of each but the first, takes.
  std::size_t adapted = 0;
  double adapt_s = 0;
  std::map<std::string, std::vector<std::string>> unlearnt;  // Takes by why.
  for (std::size_t t = 0; t < takes.size(); ++t) {
    MIEN_TRY_ASSIGN(const std::vector<solve::Solution> solutions,
                    model.solve_by_each(takes[t], takes[t].path().string(), all));
    const solve::Solution& solution = solutions.front();
    if (solution.personalised && solution.personalised->taken) ++adapted;
    adapt_s += solution.personalise_s;
    if (!solution.unlearnt.empty()) unlearnt[solution.unlearnt].push_back(takes[t].path().string());
    estimates.push_back(solve::with_truth(takes[t].path().string(), solution, truths[t]));
    for (std::size_t i = 0; i < others.size(); ++i) others[i].push_back(weights_of(solutions[i + 1]));
  }
  const measure::Meter meter(face);
  MIEN_TRY_ASSIGN(measure::Evaluation evaluation, measure::evaluate(meter, estimates, model.mean_pose()));
  for (std::size_t i = 0; i < ablated.size(); ++i)
    evaluation.ablations.push_back(
        measure::measure_ablation(meter, estimates, ablated[i].without, others[i]));
  if (options.blink) evaluation.blinking = measure::measure_shaped(meter, estimates, others.back());
  if (options.every_min > 0)
    for (const measure::TakeEstimates& take : estimates)
      evaluation.pieces.push_back(
          {take.take, measure::pieces_of(take.truth, take.model, model.mean_pose(), 60 * options.every_min)});
  if (options.wears > 0) {
    MIEN_TRY_ASSIGN(evaluation.wears, measure_wears(options.wears, takes, model, shaping, meter));
  }
  evaluation.ece = solve::expected_region_error(estimates);
  say_unlearnt(unlearnt);
  if (adapted > 0 && adapted < takes.size())
    fmt::print(stderr,
               "mien: the wearer was learnt on {} of the {} takes; evaluate them apart to tell them apart\n",
               adapted, takes.size());
  measure::EvaluationContext context{
      .face = face_name,
      .model = options.model.path,
      .devices = devices.size() == 1 ? *devices.begin() : "mixed",
      .steps = model.steps(),
      .adapted = adapted == takes.size(),
      .adapt_s = adapt_s,
      .told = std::move(told),
  };
  for (const std::string& name : model.recorded())
    if (performed.contains(name)) context.trained_on.push_back(one_line(name));
  if (!options.report.empty())
    MIEN_TRY(measure::evaluation_report(evaluation, context).write(options.report));
  if (options.json) {
    const std::string text = measure::evaluation_json(evaluation, context) + "\n";
    std::fwrite(text.data(), 1, text.size(), stdout);
    return {};
  }
  fmt::print("{} frames of {} take{} on {}, {} profile, {}; model {}\n\n", evaluation.frames,
             evaluation.takes, evaluation.takes == 1 ? "" : "s", face_name, context.devices,
             measure::asked_how(context), one_line(context.model));
  std::vector<std::string> first = measure::caveats(context);
  std::ranges::move(measure::baselines_ahead(evaluation), std::back_inserter(first));
  for (const std::string& sentence : first) fmt::print("{}\n", sentence);
  if (!first.empty()) fmt::print("\n");
  fmt::print("{:<13} {:>7} {:>7} {:>7} {:>8} {:>9} {:>7} {:>8}\n", "", "PVE mm", "face mm", "LMK mm", "MSE",
             "MSE of 42", "jitter", "blink F1");
  print_row("model", evaluation.model);
  if (evaluation.blinking) print_row("with blinks", *evaluation.blinking);
  if (evaluation.ridge) print_row("ridge", *evaluation.ridge);
  print_row("hold last", evaluation.hold_last);
  print_row("mean pose", evaluation.mean_pose);
  if (const measure::Table wears = measure::wears_table(evaluation); !wears.rows.empty())
    fmt::print("\n{}", measure::plain_text(wears));
  fmt::print("\n{}", measure::plain_text(measure::motion_table(evaluation)));
  if (const measure::Table eyes = measure::eyes_and_lips_table(evaluation); !eyes.rows.empty())
    fmt::print("\n{}", measure::plain_text(eyes));
  if (!evaluation.ablations.empty())
    fmt::print("\nthe model with a step of shaping left out (=: no bit changes)\n");
  for (const measure::Ablation& one : evaluation.ablations)
    print_row((one.without + (one.changed ? "" : " =")).c_str(), one.metrics);
  for (const measure::TakePieces& of : evaluation.pieces) print_pieces(of);
  if (evaluation.model.mse > evaluation.mean_pose.mse &&
      evaluation.model.mse_observed < evaluation.mean_pose.mse_observed)
    fmt::print(
        "\nMSE is above the mean pose's because of gaze, eyeWide and mouthShrugUpper: without them (MSE of "
        "42) it is below. They move few vertices.\n");
  fmt::print("\nhold last is the truth of a second ago, which no tracker has (docs/reference/metrics.md)\n");
  if (!options.report.empty()) fmt::print("\nreport: {}\n", options.report);
  return {};
}

}  // namespace

void add_evaluate_command(Commands& commands) {
  auto options = std::make_shared<EvaluateOptions>();
  const Command command = commands.add(
      "evaluate", "Measures a model on takes with truth, beside its baselines",
      "mien evaluate take.mien --report take.html", [options] { return run_evaluate(*options); });
  command.add_option("takes", options->takes, "Takes with a truth track, or with --truth").required();
  options->model.add_to(command);
  options->shaping.add_to(command);
  options->phone.add_to(command, "Measure against what a phone told and not the take's own truth track");
  command.add_flag("--ablate", options->ablate,
                   "Measure once more with each step of shaping left out: one row a step. Shapes by the "
                   "defaults where no --shaping says otherwise");
  command.add_flag(
      "--blink", options->blink,
      "Measure once more with the blinks that a session makes for lids which no sensor observes; "
      "without it they are left out");
  command
      .add_option(
          "--every", options->every_min,
          "Also print the error of each piece of this many minutes of a take: whether it stays as it began")
      .in_range(0.1, 600.0);
  command
      .add_option(
          "--wears", options->wears,
          "Also perform the takes' truth anew so many times, the sensors put on otherwise each time, and "
          "print the errors' mean and 95 % interval over these wears; of performed takes. More: narrower "
          "intervals, longer work")
      .in_range(3, 100)
      .excludes(command.option("--truth"));
  command.add_option("--face", options->face,
                     "Face to measure on (default: the take's own where it is found, else builtin)");
  command.add_option("--report", options->report, "Write a self-contained HTML page with plots");
  command
      .add_flag("--no-adapt", options->no_adapt,
                "Do not personalise the live model on a take's full prologue first; with --truth, and of a "
                "model that learnt from a phone, it never is")
      .excludes(command.option("--window"));
  add_json_flag(command, options->json);
}

}  // namespace mien::app
