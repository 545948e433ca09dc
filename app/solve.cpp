#include <chrono>
#include <memory>

#include "app/command.h"
#include "app/json_output.h"
#include "app/model_option.h"
#include "app/write_motion.h"
#include "mien/solve/solve.h"

namespace mien::app {
namespace {

struct SolveOptions {
  std::string take;
  ModelOption model;
  ShapingOption shaping;
  std::string out;
  std::string face;
  bool json = false;
};

Result<void> run_solve(SolveOptions options) {
  if (!options.out.empty()) MIEN_TRY(check_motion_output(options.out));
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(options.take));
  MIEN_TRY_ASSIGN(const OpenModel::Shaping shaping, options.shaping.read());
  MIEN_TRY_ASSIGN(const OpenModel model, options.model.open(take.rig()));
  const auto start = std::chrono::steady_clock::now();
  MIEN_TRY_ASSIGN(const solve::Solution solution, model.solve(take, "solve", shaping));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!options.out.empty())
    MIEN_TRY(write_motion(motion_of(solution.frames),
                          options.face.empty() ? take.header().face : options.face, options.out));
  if (options.json) {
    print_json({{"take", options.take},
                {"model", options.model.path},
                {"frames", solution.frames.size()},
                {"observed", solution.observed},
                {"kernels", model.kernels()},
                {"hash", solution.hash},
                {"seconds", seconds},
                {"out", options.out}});
  } else {
    fmt::print("{} frames in {:.1f} s\nkernels {}\nhash    {}\n", solution.frames.size(), seconds,
               model.kernels(), solution.hash);
    if (!options.out.empty()) fmt::print("wrote   {}\n", options.out);
  }
  return {};
}

}  // namespace

void add_solve_command(Commands& commands) {
  auto options = std::make_shared<SolveOptions>();
  const Command command =
      commands.add("solve", "Turns a take's sensors into blendshape weights",
                   "mien solve take.mien --out take.csv", [options] { return run_solve(*options); });
  command.add_option("take", options->take, "The take").required();
  options->model.add_to(command);
  options->shaping.add_to(command);
  command.add_option("--out", options->out, "Write the weights: .csv (Live Link Face), .glb or .gltf");
  command.add_option("--face", options->face, "Face of a .glb or .gltf (default: the take's own)");
  add_json_flag(command, options->json);
}

}  // namespace mien::app
