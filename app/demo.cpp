#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "app/command.h"
#include "app/film.h"
#include "app/json_output.h"
#include "app/media_helper.h"
#include "app/model_option.h"
#include "app/performance.h"
#include "app/read_aloud.h"
#include "app/write_motion.h"
#include "mien/core/files.h"
#include "mien/face/livelink_csv.h"
#include "mien/face/load.h"
#include "mien/model/kernels.h"
#include "mien/study/evaluation_report.h"
#include "mien/study/solve.h"
#include "mien/virtual/perform_take.h"

namespace mien::app {
namespace {

struct Options {
  std::filesystem::path out = "out/demo";
  std::uint64_t seed = 2026;
  double seconds = 8;
  ModelOption model;
  bool json = false;
};

/// When the frames that count begin, from the first frame.
double evaluated_from_s(const std::vector<take::TruthFrame>& truth) {
  for (const take::TruthFrame& frame : truth)
    if (frame.evaluated) return to_seconds(frame.time - truth.front().time);
  return 0;
}

Result<void> run(Options options) {
  // What it needs at its end is looked for before its beginning.
  MIEN_TRY_ASSIGN(const OpenModel model, options.model.open());
  MIEN_TRY(find_helper("mien-media"));
  std::error_code code;
  std::filesystem::create_directories(options.out, code);
  if (code)
    return fail(ErrorCode::io, code.message(), options.out.string(),
                "choose a folder that can be written with --out");

  // A person whom the model has never met: identity, style and placement come from a seed that training did
  // not use.
  virt::PerformRequest request;
  request.face = fmt::format("builtin:{}", options.seed);
  request.seed = options.seed;
  constexpr virt::Block kSaid =
      virt::Block::acted;  // A face that speaks and feels says more than one that exercises.
  request.script = virt::default_script(kSaid, options.seconds);
  request.script_name = virt::block_name(kSaid);
  MIEN_TRY_ASSIGN(request.sound, read_aloud(request.script, no_progress));
  request.take = options.out / "performance.mien";
  request.replace = true;
  request.software = "mien " MIEN_VERSION;
  MIEN_TRY_ASSIGN(request.rig, find_resource("rigs/default.toml"));
  MIEN_TRY(virt::perform_take(request, terminal_progress("1/4 performing")));

  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(request.take));
  MIEN_TRY_ASSIGN(const study::Solution solution,
                  model.solve(take, study::SolveFrom::samples, "2/4 capturing"));
  MIEN_TRY_ASSIGN(const study::TakeEstimates estimates, study::with_truth(take, solution));
  MIEN_TRY_ASSIGN(const face::Face face, face::load_face(request.face));
  face::BlendshapeWeights mean_pose;
  std::ranges::copy(model.file().mean_pose, mean_pose.values.begin());
  MIEN_TRY_ASSIGN(const study::Evaluation evaluation,
                  study::evaluate(study::Meter(face), {estimates}, mean_pose));

  const Progress writing = terminal_progress("3/4 writing");
  const face::Motion capture = motion_of(solution.frames);
  MIEN_TRY(write_motion(capture, request.face, options.out / "capture.csv"));
  writing(0.3, "capture.glb");
  MIEN_TRY(write_motion(capture, request.face, options.out / "capture.glb"));
  writing(1, "capture.csv, capture.glb");

  MIEN_TRY_ASSIGN(const Performance truth, load_performance(request.take));
  FilmOptions film;
  film.width = 272;
  film.height = 304;
  film.rate_hz = 15;
  film.sound = truth.sound;
  film.from_s = evaluated_from_s(estimates.truth);
  const std::filesystem::path film_path = options.out / "capture.mp4";
  MIEN_TRY_ASSIGN(const FilmMade made, film_comparison(face, truth.motion, capture, 0, film, film_path,
                                                       terminal_progress("4/4 filming")));

  const study::EvaluationContext context{.face = request.face,
                                         .model = options.model.path,
                                         .devices = request.devices,
                                         .steps = model.steps()};
  study::Report report = study::evaluation_report(evaluation, context);
  report.heading("Truth, capture, and the capture's error as colour");
  MIEN_TRY_ASSIGN(const std::vector<std::byte> mp4, read_file(film_path));
  report.film(mp4, "A virtual performer whom the model has never met, captured by twelve simulated IMUs");
  MIEN_TRY(report.write(options.out / "report.html"));

  if (options.json) {
    print_json({{"report", (options.out / "report.html").string()},
                {"film", film_path.string()},
                {"csv", (options.out / "capture.csv").string()},
                {"gltf", (options.out / "capture.glb").string()},
                {"take", request.take.string()},
                {"frames", solution.frames.size()},
                {"kernels", model::kernel_name()},
                {"hash", solution.hash},
                {"pve_mm", evaluation.model.pve_mm.mean},
                {"film_frames", made.frames}});
  } else {
    fmt::print(
        "Captured {:.0f} s of a face that the model had never met: vertices within {:.2f} mm on average",
        static_cast<double>(evaluation.frames) / kFrameRateHz, evaluation.model.pve_mm.mean);
    if (evaluation.ridge) fmt::print(" (ridge regression: {:.2f} mm)", evaluation.ridge->pve_mm.mean);
    fmt::print(".\nIn {}: report.html, capture.mp4, capture.csv, capture.glb, performance.mien\n",
               options.out.string());
  }
  return {};
}

}  // namespace

void add_demo_command(Commands& commands) {
  auto options = std::make_shared<Options>();
  CLI::App* command = commands.add("demo",
                                   "The main job with no hardware: a virtual performer is captured; a "
                                   "report, a film, a CSV and a glTF come out",
                                   "mien demo --out out/demo", [options] { return run(*options); });
  command->add_option("--out", options->out, "Folder for what comes out")->capture_default_str();
  command->add_option("--seed", options->seed, "Who performs")->capture_default_str();
  command->add_option("--seconds", options->seconds, "How long")
      ->check(number_between(2.0, 600.0))
      ->capture_default_str();
  options->model.add_to(command);
  command->add_flag("--json", options->json, "Print one JSON object");
}

}  // namespace mien::app
