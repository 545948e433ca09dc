#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <span>
#include <utility>

#include "app/child_program.h"
#include "app/chosen_face.h"
#include "app/command.h"
#include "app/film.h"
#include "app/json_output.h"
#include "app/live/demo_dataset.h"
#include "app/live/demo_session.h"
#include "app/live/perform_network.h"
#include "app/live/running_session.h"
#include "app/media_helper.h"
#include "app/performance.h"
#include "app/private_folder.h"
#include "app/read_aloud.h"
#include "app/seed_option.h"
#include "app/write_motion.h"
#include "mien/core/files.h"
#include "mien/measure/evaluation_report.h"
#include "mien/modalities/modalities.h"
#include "mien/model/model_file.h"
#include "mien/render/lettering.h"
#include "mien/sensor/rig.h"
#include "mien/solve/solve.h"
#include "mien/virtual/perform_take.h"

namespace mien::app {
namespace {

struct DemoOptions {
  std::filesystem::path out = "out/demo";
  std::uint64_t seed = 2026;
  double seconds = 8;
  std::string page = "127.0.0.1:8740";
  std::string model;
  bool record_dataset = false;
  std::string texts = "dataset_try";
  bool json = false;
};

/// The live half: a performer's nodes send through real sockets to a session that tracks, records and shows.
struct Captured {
  live::EngineSummary summary;
  NetworkSummary performed;
};

Result<Captured> capture_live(const DemoOptions& options, const virt::PerformRequest& performance,
                              const std::filesystem::path& take) {
  LiveRequest request;
  request.model = options.model;
  request.listen = {"udp://127.0.0.1:0"};
  request.record = take;
  request.force = true;
  request.takes = options.out;
  request.face = performance.face;
  request.performer = fmt::format("virtual:{}", options.seed);
  request.page = options.page;
  MIEN_TRY_ASSIGN(const LiveSession opened, open_demo_session(request));
  live::Engine& engine = *opened.engine;

  RunningSession session(engine);
  NetworkOptions network;
  network.to = engine.listening().front();
  network.loop = true;
  network.title = "2/5 capturing live, in real time";
  // Once, when nobody watches; else until the page is closed.
  network.enough = [&](std::size_t round) { return round > 1 && engine.watchers() == 0; };
  auto performed = perform_to_network(performance, network);
  auto summary = session.finish();
  if (!performed) return std::unexpected(performed.error());
  if (!summary) return std::unexpected(summary.error());
  if (performed->stopped) return fail(ErrorCode::cancelled, "stopped", options.out.string());
  if (!summary->recording_error.empty()) return fail(ErrorCode::io, summary->recording_error, take.string());
  return Captured{std::move(*summary), std::move(*performed)};
}

/// The frames that count, as motions that begin together.
struct Pair {
  face::Motion truth, capture;
};
Pair motions_of(const measure::TakeEstimates& estimates, std::span<const face::OutputFrame> frames) {
  Pair out;
  out.truth.name = "truth";
  std::vector<face::OutputFrame> counted;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!estimates.truth[i].evaluated) continue;
    face::MotionFrame truth;
    truth.time_s = counted.empty() ? 0 : to_seconds(frames[i].time - counted.front().time);
    truth.weights = estimates.truth[i].weights;
    truth.tongue_out = estimates.truth[i].tongue_out;
    out.truth.frames.push_back(truth);
    counted.push_back(frames[i]);
  }
  out.capture = motion_of(counted);
  return out;
}

Result<void> run_demo(DemoOptions options) {
  // What it needs at its end is looked for before its beginning.
  MIEN_TRY_ASSIGN(const std::filesystem::path rig, find_resource("rigs/default.toml"));
  MIEN_TRY_ASSIGN(const sensor::Rig sensors, sensor::read_rig(rig));
  MIEN_TRY_ASSIGN(const std::filesystem::path model_path, modalities::live_model(sensors, options.model));
  MIEN_TRY_ASSIGN(const model::ModelFile model, model::read_model(model_path));
  MIEN_TRY(find_helper("mien-media"));
  MIEN_TRY(render::Lettering::load());
  MIEN_TRY(make_private_folders(options.out));

  // A person whom the model has never met: identity, style and placement come from a seed that training did
  // not use.
  virt::PerformRequest request;
  request.face = fmt::format("builtin:{}", options.seed);
  request.seed = options.seed;
  constexpr performer::Block kSaid =
      performer::Block::acted;  // A face that speaks and feels says more than one that exercises.
  request.script = performer::default_script(kSaid, options.seconds);
  request.script_name = performer::block_name(kSaid);
  MIEN_TRY_ASSIGN(request.sound, read_aloud(std::span(&request.script, 1), no_progress));
  request.take = options.out / "performance.mien";
  request.replace = true;
  request.software = "mien " MIEN_VERSION;
  request.rig = rig;
  MIEN_TRY(virt::perform_take(request, terminal_progress("1/5 performing")));

  const std::filesystem::path live_path = options.out / "live.mien";
  MIEN_TRY_ASSIGN(const Captured captured, capture_live(options, request, live_path));

  // The take that was recorded gives the session's frames again, to the bit.
  MIEN_TRY_ASSIGN(const take::Take live_take, take::Take::open(live_path));
  modalities::LiveModel live_model(model_path);
  live_model.imu = model;
  MIEN_TRY_ASSIGN(const solve::Solution solution,
                  solve::replay_take(live_take, live_model, terminal_progress("3/5 replaying the take")));
  const bool same_bits = solution.hash == captured.summary.hash;
  // What is measured is the tracker's answer, without the blinks that the session makes.
  MIEN_TRY_ASSIGN(const solve::Solution unblinking,
                  solve::replay_take(live_take, live_model, no_progress, {.blinks_per_min = 0}));

  MIEN_TRY_ASSIGN(const take::Take truth_take, take::Take::open(request.take));
  MIEN_TRY_ASSIGN(const std::vector<take::TruthFrame> truth, solve::own_truth(truth_take));
  const measure::TakeEstimates estimates = solve::with_truth(request.take, unblinking, truth);
  MIEN_TRY_ASSIGN(const face::Face face, chosen_face(request.face));
  face::BlendshapeWeights mean_pose;
  std::ranges::copy(model.mean_pose, mean_pose.values.begin());
  const Progress writing = terminal_progress("4/5 measuring and writing");
  writing(0.1, "the capture beside the truth");
  const measure::Meter meter(face);
  MIEN_TRY_ASSIGN(measure::Evaluation evaluation, measure::evaluate(meter, {estimates}, mean_pose));
  evaluation.blinking =
      measure::measure_shaped(meter, {estimates}, {{solve::with_truth(request.take, solution, truth).model}});

  const Pair motions = motions_of(estimates, solution.frames);
  MIEN_TRY(write_motion(motions.capture, request.face, options.out / "capture.csv"));
  writing(0.7, "capture.glb");
  MIEN_TRY(write_motion(motions.capture, request.face, options.out / "capture.glb"));
  writing(1, "capture.csv, capture.glb");

  FilmOptions film;
  film.width = 428;
  film.height = 480;
  film.rate_hz = 20;  // Each third frame of the capture, which needs no interpolation.
  film.sound = request.sound;
  const std::filesystem::path film_path = options.out / "capture.mp4";
  MIEN_TRY_ASSIGN(const FilmMade made, film_comparison(face, motions.truth, motions.capture, 0, film,
                                                       film_path, terminal_progress("5/5 filming")));

  const measure::EvaluationContext context{
      .face = request.face, .model = model_path.string(), .devices = request.devices, .steps = 0};
  measure::Report report = measure::evaluation_report(evaluation, context);
  report.heading("Truth, live capture, and the capture's error as colour");
  MIEN_TRY_ASSIGN(const std::vector<std::byte> mp4, read_file(film_path));
  report.film(mp4,
              "A virtual performer whom the model has never met, captured live by twelve simulated IMUs");
  MIEN_TRY(report.write(options.out / "report.html"));

  const double p50_ms = 1e3 * to_seconds(captured.summary.latency.percentile(0.5));
  const double p99_ms = 1e3 * to_seconds(captured.summary.latency.percentile(0.99));
  if (options.json) {
    print_json({{"report", (options.out / "report.html").string()},
                {"film", film_path.string()},
                {"csv", (options.out / "capture.csv").string()},
                {"gltf", (options.out / "capture.glb").string()},
                {"take", live_path.string()},
                {"frames", captured.summary.frames},
                {"missed", captured.summary.missed},
                {"kernels", captured.summary.kernels},
                {"hash", captured.summary.hash},
                {"same_bits", same_bits},
                {"latency_ms", {{"p50", p50_ms}, {"p99", p99_ms}}},
                {"packets", captured.performed.packets},
                {"pve_mm", evaluation.model.pve_mm.mean},
                {"film_frames", made.frames}});
  } else {
    fmt::print(
        "Captured {:.0f} s live of a face that the model had never met: vertices within {:.2f} mm on "
        "average; "
        "{:.1f} ms from the last packet to the frame (99 of 100 within {:.1f} ms), {} frames missed.\n",
        static_cast<double>(evaluation.frames) / kFrameRateHz, evaluation.model.pve_mm.mean, p50_ms, p99_ms,
        captured.summary.missed);
    fmt::print("{}\nIn {}: report.html, capture.mp4, capture.csv, capture.glb, live.mien, performance.mien\n",
               same_bits ? "The take replays to the same bits."
                         : "The take does not replay to the same bits: please report this.",
               options.out.string());
  }
  if (!same_bits)
    return fail(ErrorCode::internal, "the take does not replay to the same bits", live_path.string());
  return {};
}

Result<void> run_dataset_demo(const DemoOptions& options) {
  if (options.page == "off")
    return fail(ErrorCode::bad_usage, "a dataset is recorded from the page, by its protocol", "--page off",
                "leave it out with --record-dataset");
  MIEN_TRY(find_helper("mien-media"));
  MIEN_TRY(make_private_folders(options.out));
  MIEN_TRY_ASSIGN(const RecordedDemo recorded, record_demo_dataset({.out = options.out,
                                                                    .seed = options.seed,
                                                                    .script = options.texts,
                                                                    .page = options.page,
                                                                    .model = options.model}));
  if (options.json) {
    print_json({{"dataset", recorded.dataset.string()},
                {"take", recorded.take.string()},
                {"lines", recorded.lines},
                {"poor", recorded.poor}});
  } else {
    fmt::print(
        "Recorded {} lines into {}, with a phone's truth, sound and consent.\n"
        "{}"
        "Look at it:  mien dataset {}\n"
        "Train on it: mien train models/recipes/live_takes.toml --takes {} --from models/live.safetensors "
        "--out "
        "mine.safetensors\n",
        recorded.lines, recorded.take.string(),
        recorded.poor.empty()
            ? ""
            : fmt::format("Poor, and asked for again of a person: {}\n", fmt::join(recorded.poor, "; ")),
        recorded.dataset.string(), recorded.dataset.string());
  }
  return {};
}

}  // namespace

void add_demo_command(Commands& commands) {
  auto options = std::make_shared<DemoOptions>();
  const Command command = commands.add(
      "demo", "The main job with no hardware: a virtual performer, live",
      "mien demo --out out/demo\n  mien demo --record-dataset --out out/demo",
      [options] { return options->record_dataset ? run_dataset_demo(*options) : run_demo(*options); });
  command.add_option("--out", options->out, "Folder for what comes out: report, film, CSV and glTF")
      .show_default();
  add_seed_option(command, options->seed, "Who performs");
  command.add_option("--seconds", options->seconds, "How long").number_between(2.0, 600.0).show_default();
  command.add_option("--model", options->model, "The live model (default: models/live.safetensors)");
  command.add_flag(
      "--record-dataset", options->record_dataset,
      "Instead, what Record a dataset on the page does: the virtual performer consents, reads and "
      "makes faces before a virtual phone, in real time, into a take to train on");
  command
      .add_option(
          "--texts", options->texts,
          "What is read then: a recording script of ours by name (dataset_en takes a quarter of an hour), "
          "or a TOML file")
      .show_default();
  command.add_option("--page", options->page, "Where the page is served: HOST:PORT, or off").show_default();
  add_json_flag(command, options->json);
}

}  // namespace mien::app
