#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <filesystem>
#include <memory>

#include "app/command.h"
#include "app/json_output.h"
#include "mien/core/files.h"
#include "mien/face/load_motion.h"
#include "mien/take/take.h"

namespace mien::app {
namespace {

struct Options {
  std::string motion, take, performer = "unknown", rig;
  bool force = false;
  bool json = false;
};

Result<void> run(const Options& options) {
  MIEN_TRY(check_output(options.take, {".mien"}));
  std::vector<std::string> warnings;
  MIEN_TRY_ASSIGN(const face::Motion motion, face::load_motion(options.motion, &warnings));
  for (const std::string& warning : warnings) fmt::print(stderr, "mien: {}: {}\n", options.motion, warning);
  std::filesystem::path rig = options.rig;
  if (rig.empty()) {
    MIEN_TRY_ASSIGN(rig, find_resource("rigs/default.toml"));
  }
  take::Header header;
  MIEN_TRY_ASSIGN(header.rig_toml, read_text(rig));
  header.software = "mien " MIEN_VERSION;
  header.performer = options.performer;
  header.script = std::filesystem::path(options.motion).filename().string();
  header.devices = "none";
  header.face = "builtin";
  header.prologue = "none";
  header.created_utc = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  MIEN_TRY_ASSIGN(take::TakeWriter writer, take::TakeWriter::create(options.take, header, options.force,
                                                                    take::Appears::when_finished));
  const Progress progress = terminal_progress("import");
  std::size_t lost = 0, written = 0;
  for (const face::MotionFrame& frame : motion.frames) {
    if (!progress(static_cast<double>(written++) / static_cast<double>(motion.frames.size()), "writing"))
      return fail(ErrorCode::cancelled, "stopped", options.take, "nothing was kept");
    take::TruthFrame truth;
    truth.time = DeviceTime(from_seconds(frame.time_s));
    truth.weights = frame.weights;
    truth.tongue_out = frame.tongue_out;
    truth.has_face = frame.has_face;
    lost += frame.has_face ? 0 : 1;
    writer.add_truth(truth);
  }
  MIEN_TRY(writer.finish());
  progress(1, "written");
  if (options.json) {
    print_json({{"take", options.take},
                {"frames", motion.frames.size()},
                {"lost", lost},
                {"duration_s", motion.duration_s()}});
  } else {
    fmt::print("{}: {:.1f} s, {} frames of truth, {} without a face\n", options.take, motion.duration_s(),
               motion.frames.size(), lost);
  }
  return {};
}

}  // namespace

void add_import_command(Commands& commands) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      commands.add("import", "Makes a take of a recorded motion: its weights become the take's truth",
                   "mien import MySlate_3.csv --take alex.mien", [options] { return run(*options); });
  command->add_option("motion", options->motion, "A Live Link Face CSV")->required();
  command->add_option("--take", options->take, "The take to write")->required();
  command->add_option("--performer", options->performer, "Who performed")->capture_default_str();
  command->add_option("--rig", options->rig, "Which sensors were worn (default: rigs/default.toml)");
  command->add_flag("--force", options->force, "Replace an existing take");
  command->add_flag("--json", options->json, "Print one JSON object");
}

}  // namespace mien::app
