#include <fmt/format.h>

#include <memory>

#include "app/command.h"
#include "app/json_output.h"
#include "app/performance.h"
#include "app/write_motion.h"

namespace mien::app {
namespace {

struct Options {
  std::string motion, face, out;
  bool json = false;
};

Result<void> run(Options options) {
  MIEN_TRY_ASSIGN(const Performance performance, load_performance(options.motion));
  if (options.face.empty()) options.face = performance.face.empty() ? "builtin" : performance.face;
  MIEN_TRY(write_motion(performance.motion, options.face, options.out));
  if (options.json)
    print_json({{"out", options.out},
                {"face", options.face},
                {"frames", performance.motion.frames.size()},
                {"duration_s", performance.motion.duration_s()}});
  else
    fmt::print("wrote {}\n", options.out);
  return {};
}

}  // namespace

void add_export_command(Commands& commands) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      commands.add("export", "Writes a motion as Live Link CSV or as animated glTF",
                   "mien export --motion take.mien --out take.glb", [options] { return run(*options); });
  command->add_option("--motion", options->motion, "A Live Link CSV, or a take, whose truth it is")
      ->required();
  command->add_option("--face", options->face,
                      "For glTF: builtin, a folder with generic_neutral_mesh.obj, or a .glb or .vrm; the "
                      "take's own unless told");
  command->add_option("--out", options->out, "The .csv, .glb or .gltf to write")->required();
  command->add_flag("--json", options->json, "Print one JSON object");
}

}  // namespace mien::app
