#include "lab/bench/benchmarks.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/command.h"
#include "app/json_output.h"
#include "app/trainer_helper.h"
#include "lab/bench/clock.h"
#include "lab/bench/onnx_peer.h"
#include "lab/commands/output.h"
#include "lab/crowd.h"
#include "lab/peak.h"
#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/face/frame_hash.h"
#include "mien/model/precision.h"
#include "mien/tracker/causal_tracker.h"

namespace mien::lab {
namespace {

/// What `mien bench causal` is asked.
struct CausalBench {
  std::string model;  ///< Empty: the default live model.
  std::string precision{model::precision_name(tracker::kLivePrecision)};
  int frames = 3600;
  bool no_peers = false;  ///< ONNX Runtime and libtorch are not run.
  Output to;
};

/// How fast somebody else's run time does the same cached step with the same weights, in fp32 on one thread.
struct Peer {
  std::optional<double> step_us;  ///< Of a step; nothing where the peer is not here.
  std::string why_not;            ///< Then the reason, for people.
};

/// ONNX Runtime, on the model exported to ONNX: the quickest rounds of its best graph
/// (lab/bench/onnx_peer.h).
Peer onnxruntime_step(const std::filesystem::path& model) {
  const auto times = measure_onnxruntime({.model = model});
  if (!times) return {.step_us = std::nullopt, .why_not = times.error().message()};
  return {.step_us = 1e6 * times->best_step_s, .why_not = {}};
}

/// libtorch, in the helper mien-train: its quickest rounds.
Peer libtorch_step(const std::filesystem::path& model) {
  const auto said = app::ask_trainer({"step", model.string(), "--json"});
  if (!said) return {.step_us = std::nullopt, .why_not = said.error().message()};
  const auto told = nlohmann::json::parse(*said, nullptr, false);
  if (!told.is_object() || !told.contains("step_us") || !told["step_us"].is_number())
    return {.step_us = std::nullopt, .why_not = "mien-train did not say how long a step took"};
  return {.step_us = told["step_us"].get<double>(), .why_not = {}};
}

constexpr double kFrameS = 1.0 / 60;
/// Of what the third cache's rate is measured: more than most second caches, less than most third ones.
constexpr std::size_t kCacheBytes = std::size_t{8} << 20;
constexpr std::size_t kCrowd = 500;

/// Sensors that turn and shake, each in its own way; the same in every run.
model::FeatureFrame moving_sensors(std::size_t sensors, std::size_t frame, std::size_t performer) {
  model::FeatureFrame out;
  out.time = DeviceTime(frame_offset(static_cast<std::int64_t>(frame)));
  out.sensors.resize(sensors);
  const double t = static_cast<double>(frame) * kFrameS + 0.37 * static_cast<double>(performer);
  for (std::size_t s = 0; s < sensors; ++s) {
    model::SensorFeature& sensor = out.sensors[s];
    const double phase = static_cast<double>(s), half = 0.1 * std::sin(7 * t + phase);
    sensor.rotation = {static_cast<float>(std::cos(half)), static_cast<float>(std::sin(half)), 0, 0};
    sensor.accel_m_s2 = {static_cast<float>(std::sin(11 * t + phase)), 0.1F, 0};
    sensor.has_rotation = sensor.has_accel = true;
  }
  return out;
}

struct PacedFrames {
  Spread frame;
  std::string hash;
};

/// Whole frames, sixty a second, with cold caches.
Result<PacedFrames> measure_paced(tracker::CausalTracker& tracker, std::size_t frames,
                                  const Progress& progress) {
  face::FrameHash hash;
  face::OutputFrame out;
  tracker.reset();
  const std::size_t sensors = tracker.file().features.sensors.size();
  std::vector<model::FeatureFrame> features;
  for (std::size_t f = 0; f < frames; ++f) features.push_back(moving_sensors(sensors, f, 0));
  MIEN_TRY_ASSIGN(std::vector<double> took,
                  measure_sixty_hz(frames, "bench causal", "frames", progress, [&](std::size_t f) {
                    tracker.step(features[f], out);
                    hash.add(out);
                  }));
  return PacedFrames{spread_of(std::move(took)), hash.hex()};
}

/// One step of the network with everything where it was the last time.
double measure_hot_step(const model::CausalNetwork& network) {
  constexpr std::size_t kSteps = 16, kTries = 200;
  model::CausalNetwork::State state(network);
  const std::vector<float> condition(network.architecture().condition, 0.1F);
  std::vector<float> out(network.architecture().outputs);
  return measure_hot(kSteps, kTries, [&] { network.step(condition, state, out); });
}

/// Frames of 500 performers, of as many at a time as go through the network together: short enough that a
/// neighbour's work falls between.
Spread measure_crowd(Crowd& crowd, std::size_t sensors) {
  constexpr std::size_t kFrames = 60;
  std::vector<std::size_t> due(Crowd::kTogether);
  std::vector<model::FeatureFrame> features(due.size());
  std::vector<face::OutputFrame> out(due.size());
  std::vector<double> took;
  for (std::size_t f = 0; f < kFrames; ++f)
    for (std::size_t first = 0; first + due.size() <= kCrowd; first += due.size()) {
      for (std::size_t i = 0; i < due.size(); ++i) {
        due[i] = first + i;
        features[i] = moving_sensors(sensors, f, due[i]);
      }
      const auto from = Clock::now();
      crowd.step(due, features, out);
      took.push_back(seconds_since(from));
    }
  return spread_of(std::move(took));
}

struct CausalFigures {
  PacedFrames paced;
  double peak_gflops = 0, cache_gb_s = 0, hot_step_s = 0;
  std::size_t weight_bytes = 0;
  double flop = 0;  ///< A step's.
  Spread crowd;     ///< A frame of Crowd::kTogether performers.
  Peer onnxruntime, libtorch;

  [[nodiscard]] double streamed_gb_s() const { return 1e-9 * static_cast<double>(weight_bytes) / hot_step_s; }
  [[nodiscard]] std::size_t performers_per_core() const {
    return static_cast<std::size_t>(static_cast<double>(Crowd::kTogether) * kFrameS / crowd.p50_s);
  }
  /// Why 500 do not fit.
  [[nodiscard]] std::string crowd_limit() const {
    return fmt::format("{} performers x 60 frames x {:.2f} MFLOP = {:.0f} GFLOP/s, of {:.0f} at most in fp32",
                       kCrowd, 1e-6 * flop, 1e-9 * flop * 60 * kCrowd, peak_gflops);
  }
};

app::Json ratio(const Peer& peer, double hot_step_s) {
  if (!peer.step_us) return nullptr;
  return 1e-6 * *peer.step_us / hot_step_s;
}

app::Json as_json(const CausalBench& options, const CausalFigures& f, const std::string& kernels) {
  app::Json json = {{"p50_ms", 1e3 * f.paced.frame.p50_s},
                    {"p99_ms", 1e3 * f.paced.frame.p99_s},
                    {"precision", options.precision},
                    {"peak_gflops", f.peak_gflops},
                    {"vs_onnxruntime", ratio(f.onnxruntime, f.hot_step_s)},
                    {"vs_libtorch", ratio(f.libtorch, f.hot_step_s)},
                    {"performers_per_core", f.performers_per_core()}};
  if (f.performers_per_core() < kCrowd) json["crowd_limit"] = f.crowd_limit();
  if (!f.onnxruntime.step_us) json["onnxruntime"] = f.onnxruntime.why_not;
  if (!f.libtorch.step_us) json["libtorch"] = f.libtorch.why_not;
  json["hash"] = f.paced.hash;
  json["frames"] = options.frames;
  json["kernels"] = kernels;
  json["model"] = options.model;
  json["passes"] = 1;
  json["crowd"] = {{"performers", kCrowd},
                   {"together", Crowd::kTogether},
                   {"p50_ms", 1e3 * f.crowd.p50_s},
                   {"p99_ms", 1e3 * f.crowd.p99_s}};
  json["hot_step_us"] = 1e6 * f.hot_step_s;
  json["weight_bytes"] = f.weight_bytes;
  json["streamed_gb_s"] = f.streamed_gb_s();
  json["cache_gb_s"] = f.cache_gb_s;
  json["streamed_share"] = f.streamed_gb_s() / f.cache_gb_s;
  return json;
}

measure::Report report_of(const CausalBench& options, const CausalFigures& f, const std::string& kernels) {
  measure::Table table{.caption = "", .columns = {"", ""}, .rows = {}, .strong_rows = {}};
  const auto line = [&](const char* what, const std::string& value) { table.rows.push_back({what, value}); };
  line("a frame at 60 a second, caches cold",
       fmt::format("p50 {:.3f} ms, p99 {:.3f} ms", 1e3 * f.paced.frame.p50_s, 1e3 * f.paced.frame.p99_s));
  line("a step in a hot loop", fmt::format("{:.1f} us", 1e6 * f.hot_step_s));
  line("  its weights",
       fmt::format("{:.2f} MB at {:.0f} GB/s, {:.0f} % of the {:.0f} GB/s that 8 MB are read at",
                   1e-6 * static_cast<double>(f.weight_bytes), f.streamed_gb_s(),
                   100 * f.streamed_gb_s() / f.cache_gb_s, f.cache_gb_s));
  const auto peer = [&](const char* name, const Peer& them) {
    line(name, them.step_us ? fmt::format("{:.1f} us, {:.2f} times ours", *them.step_us,
                                          1e-6 * *them.step_us / f.hot_step_s)
                            : them.why_not);
  };
  peer("  ONNX Runtime's, fp32", f.onnxruntime);
  peer("  libtorch's, fp32", f.libtorch);
  constexpr std::size_t kTogether = Crowd::kTogether;
  line("performers that one core carries",
       fmt::format("{}, one pass a frame ({} together: p50 {:.2f} ms, p99 {:.2f} ms)",
                   f.performers_per_core(), kTogether, 1e3 * f.crowd.p50_s, 1e3 * f.crowd.p99_s));
  line("  in operations",
       fmt::format("{:.0f} GFLOP/s; this core's fp32 peak is {:.0f}",
                   1e-9 * f.flop * static_cast<double>(kTogether) / f.crowd.p50_s, f.peak_gflops));
  if (f.performers_per_core() < kCrowd) line("  why not 500", f.crowd_limit());
  measure::Report report("The live model alone",
                         fmt::format("{} frames of {}; kernels {}, hash {}", options.frames, options.model,
                                     kernels, f.paced.hash));
  report.table(table);
  return report;
}

/// Measures the live model's frame as a session lives it, its step in a hot loop, and how many performers one
/// core carries; beside what the core can do at most, measured in the same run. Prints it. Errors: the model
/// reader's and the tracker's; cancelled.
Result<void> run_causal_bench(const CausalBench& asked) {
  CausalBench options = asked;
  const std::optional<model::Precision> precision = model::precision_from_name(options.precision);
  if (!precision)
    return fail(ErrorCode::bad_usage, "there is no precision " + options.precision, "bench causal",
                "choose fp32, bf16 or int8");
  MIEN_TRY_ASSIGN(options.model, app::path_or(options.model, "models/live.safetensors"));
  MIEN_TRY_ASSIGN(const model::ModelFile file, model::read_model(options.model));
  auto created = tracker::CausalTracker::create(file, file.features.sensors, *precision);
  if (!created) {
    created.error().where = options.model;
    return std::unexpected(std::move(created).error());
  }
  tracker::CausalTracker& tracker = *created;
  MIEN_TRY_ASSIGN(Crowd crowd, Crowd::create(file, file.features.sensors, kCrowd, *precision));

  const Progress progress = app::terminal_progress("bench causal");
  CausalFigures f;
  f.peak_gflops = peak_gflops();
  f.cache_gb_s = read_gb_s(kCacheBytes);
  f.hot_step_s = measure_hot_step(tracker.network());
  f.weight_bytes = tracker.network().weight_bytes();
  f.flop = model::flop_count(file.architecture);
  if (options.no_peers) {
    f.onnxruntime.why_not = f.libtorch.why_not = "not asked for";
  } else {
    f.onnxruntime = onnxruntime_step(options.model);
    f.libtorch = libtorch_step(options.model);
  }
  f.crowd = measure_crowd(crowd, file.features.sensors.size());
  MIEN_TRY_ASSIGN(f.paced, measure_paced(tracker, static_cast<std::size_t>(options.frames), progress));
  const std::string kernels = model::kernel_name(*precision);
  return put_out(options.to, report_of(options, f, kernels), as_json(options, f, kernels));
}

}  // namespace

void add_causal_bench(app::Commands& commands, app::Command bench) {
  auto asked = std::make_shared<CausalBench>();
  const app::Command causal = commands.add_under(
      bench, "causal",
      "The live model alone: a whole frame paced at 60 a second with cold caches, a step in a hot loop "
      "beside other "
      "run times, and how many performers one core carries, beside the core's measured peak",
      "mien bench causal --precision int8 --json", [asked] { return run_causal_bench(*asked); });
  causal.add_option("--precision", asked->precision, "What its linear layers multiply in: fp32, bf16 or int8")
      .show_default();
  causal.add_option("--frames", asked->frames, "Frames of a 60th of a second")
      .in_range(1, 1'000'000)
      .show_default();
  causal.add_option("--model", asked->model, "The live model (default: models/live.safetensors)");
  causal.add_flag("--no-peers", asked->no_peers, "Do not run ONNX Runtime and libtorch beside it");
  app::add_json_flag(causal, asked->to.json);
}

}  // namespace mien::lab
