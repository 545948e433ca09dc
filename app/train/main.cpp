#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "app/command.h"
#include "app/media_helper.h"
#include "mien/core/files.h"
#include "mien/model/denoiser.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"
#include "mien/train/make_task.h"
#include "mien/train/parity.h"
#include "mien/train/trainer.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif
#ifdef __linux__
#include <sys/prctl.h>
#include <unistd.h>
#endif

namespace {

using namespace mien;
using Json = nlohmann::ordered_json;

struct TrainArguments {
  std::string recipe, out, from, face = "builtin", rig, films, views, takes, splits, recorded, data;
  train::TrainOptions options;
  bool json = false;
  int parent = 0;
};

/// What it was typed as: mien, where `mien train` became it.
std::string program = "mien-train";

void tell_on_stderr(const std::string& line) {
  app::clear_progress();
  fmt::print(stderr, "{}: {}\n", program, line);
}

/// Asks itself to stop, which leaves a checkpoint, when the process that started it is gone.
void end_with(int parent) {
#ifdef __linux__
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != parent) ::raise(SIGTERM);  // Gone already.
#endif
}

Result<void> run_train(const TrainArguments& arguments) {
  if (arguments.parent > 0) end_with(arguments.parent);
  MIEN_TRY_ASSIGN(const std::string text, read_text(arguments.recipe));
  MIEN_TRY_ASSIGN(const train::Recipe recipe, train::parse_recipe(text, arguments.recipe));
  MIEN_TRY_ASSIGN(const std::filesystem::path rig_path, app::path_or(arguments.rig, "rigs/default.toml"));
  train::TrainOptions options = arguments.options;
  options.out = arguments.out;
  options.from = arguments.from;
  MIEN_TRY_ASSIGN(const std::string rig_text, read_text(rig_path));
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::parse_rig(rig_text, rig_path.string()));

  std::filesystem::path films = arguments.films;
  if (films.empty()) films = std::filesystem::path(arguments.out).replace_extension(".films");
  MIEN_TRY_ASSIGN(const std::unique_ptr<train::Task> task,
                  train::make_task(recipe,
                                   {.where = arguments.recipe,
                                    .face = arguments.face,
                                    .rig = rig,
                                    .rig_text = rig_text,
                                    .speaker = app::speaker_by_helper(),
                                    .films = films,
                                    .views = arguments.views,
                                    .takes = arguments.takes,
                                    .splits = arguments.splits,
                                    .data = arguments.data,
                                    .recorded = arguments.recorded,
                                    .tell = tell_on_stderr},
                                   app::terminal_progress("data")));
  MIEN_TRY_ASSIGN(const train::TrainReport report,
                  train::train(*task, options, app::terminal_progress("training")));
  if (!report.replaced)
    tell_on_stderr(fmt::format("{} is better and stays; the new model is {}", options.out.string(),
                               report.model.string()));
  if (arguments.json) {
    Json object = {{"model", report.model.string()}, {"replaced", report.replaced}};
    object["results"] = Json::parse(report.results);
    fmt::print("{}\n", object.dump(2));
  }
  return {};
}

Result<void> run_parity(const std::string& path, bool json) {
  MIEN_TRY_ASSIGN(const model::ModelFile model, model::read_model(path));
  MIEN_TRY_ASSIGN(const train::Parity parity, train::measure_parity(model));
  if (json)
    fmt::print("{}\n", Json{{"model", path},
                            {"largest_difference", parity.largest_difference},
                            {"limit", train::kParityLimit},
                            {"calls", parity.calls},
                            {"kernels", model::kernel_name()}}
                           .dump(2));
  else
    fmt::print("largest difference {:.2e} over {} calls ({} kernels); allowed {:.0e}\n",
               parity.largest_difference, parity.calls, model::kernel_name(), train::kParityLimit);
  if (!(parity.largest_difference < train::kParityLimit))
    return fail(ErrorCode::internal,
                fmt::format("the run time differs from libtorch by {:.2e}", parity.largest_difference), path);
  return {};
}

Result<void> run_step(const std::string& path, bool json) {
  MIEN_TRY_ASSIGN(const model::ModelFile model, model::read_model(path));
  MIEN_TRY_ASSIGN(const train::LibtorchStep step, train::measure_libtorch_step(model));
  if (json)
    fmt::print(
        "{}\n",
        Json{{"model", path}, {"step_us", 1e6 * step.step_s}, {"largest_difference", step.largest_difference}}
            .dump(2));
  else
    fmt::print("{:.1f} us a step in libtorch, fp32, one thread; {:.2e} from the run time\n",
               1e6 * step.step_s, step.largest_difference);
  return {};
}

struct SpeedArguments {
  std::string architecture = "light", precision = "bf16", device = "cpu";
  std::size_t batch = 32, steps = 10, sensors = 11;
  double dropout = 0.1;
  int threads = 0;
  bool json = false;
};

Result<void> run_speed(const SpeedArguments& arguments) {
  train::Recipe recipe;
  MIEN_TRY_ASSIGN(recipe.architecture, model::named_architecture(arguments.architecture, 1));
  recipe.presence_flags = arguments.architecture != "faithful";
  recipe.batch = arguments.batch;
  recipe.bf16 = arguments.precision == "bf16";
  recipe.dropout = arguments.dropout;
  MIEN_TRY_ASSIGN(const double speed, train::measure_speed(recipe, arguments.sensors, arguments.steps,
                                                           arguments.device, arguments.threads));
  if (arguments.json)
    fmt::print("{}\n", Json{{"architecture", arguments.architecture},
                            {"precision", arguments.precision},
                            {"device", arguments.device},
                            {"batch", arguments.batch},
                            {"dropout", arguments.dropout},
                            {"windows_per_s", speed}}
                           .dump(2));
  else
    fmt::print("{:.1f} windows a second ({}, {}, batch {}, dropout {}, {})\n", speed, arguments.architecture,
               arguments.precision, arguments.batch, arguments.dropout, arguments.device);
  return {};
}

/// Steps ask for the same tensors of many megabytes again and again, which glibc otherwise hands back to the
/// system and gets empty pages for, a quarter of a step of a network of pictures.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
#endif
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  if (argc > 0 && std::string_view(argv[0]) == "mien") program = "mien";
  app::Commands commands(
      program, "Trains Mien's models. Started by `mien train`; parity, step and speed are its own.");
  commands.require_one(true);

  TrainArguments train;
  const app::Command train_command = commands.add(
      "train", "Makes data by a recipe, trains on them and writes a model",
      "mien train models/recipes/default.toml --out mine.safetensors", [&] { return run_train(train); });
  train_command.add_option("recipe", train.recipe, "The recipe, a TOML file").required();
  train_command.add_option("--out", train.out, "The model to write").required();
  train_command.add_option("--face", train.face, "builtin, an ICT-FaceKit folder, or a .glb or .vrm file");
  train_command.add_option("--rig", train.rig, "The sensor rig; rigs/default.toml unless told");
  train_command.add_option("--films", train.films,
                           "Folder that films of headset cameras are rendered into, and kept in for the next "
                           "training; the model's name with .films unless told");
  train_command.add_option("--views", train.views,
                           "The network of pictures whose findings a headset's memory (a causal network) "
                           "learns from, and which goes into the model");
  train_command.add_option("--takes", train.takes,
                           "Folder of people's takes with a truth, which IMUs learn from as the recipe's "
                           "[takes] says; half of each step unless told");
  train_command.add_option("--splits", train.splits,
                           "File of who of the takes is trained on and who validated on, as `mien dataset` "
                           "writes it");
  train_command.add_option("--recorded", train.recorded,
                           "Folder of recorded performances (Live Link Face CSVs), which virtual wearers of "
                           "IMUs perform as the recipe's data.recorded says");
  train_command.add_option("--data", train.data,
                           "File of performances that were made before, which IMUs learn from instead of "
                           "what the recipe's [data] says; studies write such");
  train_command.add_option("--from", train.from,
                           "Begin with this model's network and normalisation instead of with drawn "
                           "weights; --resume wants it again");
  train_command.add_flag("--resume", train.options.resume,
                         "Go on from the checkpoint of a run that was stopped");
  train_command.add_flag("--force", train.options.force, "Replace what stands there, whatever it is");
  train_command.add_option("--device", train.options.device, "cpu, cuda or cuda:N");
  train_command.add_option("--threads", train.options.threads, "Threads on the CPU; 0 takes all cores");
  train_command.add_option("--parent", train.parent,
                           "Process that started this one: stop, with a checkpoint, when it is gone");
  app::add_json_flag(train_command, train.json);

  std::string parity_model;
  bool parity_json = false;
  const app::Command parity = commands.add(
      "parity", "Compares the run time with libtorch, one call at a time",
      "mien-train parity light.safetensors", [&] { return run_parity(parity_model, parity_json); });
  parity.add_option("model", parity_model, "The model").required();
  app::add_json_flag(parity, parity_json);

  std::string step_model;
  bool step_json = false;
  const app::Command step =
      commands.add("step", "Measures libtorch's step of a causal network, a peer of the run time",
                   "mien-train step live.safetensors", [&] { return run_step(step_model, step_json); });
  step.add_option("model", step_model, "The model").required();
  app::add_json_flag(step, step_json);

  SpeedArguments speed;
  const app::Command speed_command =
      commands.add("speed", "Measures how fast this machine trains", "mien-train speed --architecture light",
                   [&] { return run_speed(speed); });
  speed_command.add_option("--architecture", speed.architecture, "light, faithful or causal");
  speed_command.add_option("--precision", speed.precision, "bf16 or fp32").one_of({"bf16", "fp32"});
  speed_command.add_option("--batch", speed.batch, "Windows a step").in_range(1, 4096);
  speed_command.add_option("--steps", speed.steps, "Steps measured").in_range(1, 10000);
  speed_command.add_option("--sensors", speed.sensors, "Sensors of the rig").in_range(1, 100);
  speed_command.add_option("--dropout", speed.dropout, "Share dropped").in_range(0.0, 0.9);
  speed_command.add_option("--device", speed.device, "cpu, cuda or cuda:N");
  speed_command.add_option("--threads", speed.threads, "Threads on the CPU; 0 takes all cores");
  app::add_json_flag(speed_command, speed.json);

  return commands.main(argc, argv, app::plain_usage_error);
}
