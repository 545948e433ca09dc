#include <filesystem>
#include <memory>
#include <system_error>

#include "app/chosen_face.h"
#include "app/command.h"
#include "app/gltf_option.h"
#include "app/json_output.h"
#include "app/performance.h"
#include "app/write_motion.h"
#include "mien/core/files.h"
#include "mien/mocap/load_marker_track.h"
#include "mien/mocap/marker_retarget.h"
#include "mien/onnx/export_model.h"

namespace mien::app {
namespace {

struct ExportOptions {
  std::string motion, face, out, markers, names, textures;
  std::string model;
  onnx::ExportRequest graph;  ///< Of a model.
  bool json = false;
};

/// A .trc can be nothing else; a .csv has weights unless markers are asked for.
bool wants_markers(const ExportOptions& options) {
  return !options.markers.empty() || std::filesystem::path(options.out).extension() == ".trc";
}

Result<void> write_markers(const face::Motion& motion, const ExportOptions& options) {
  MIEN_TRY(check_output(options.out, {".csv", ".trc"}));
  MIEN_TRY_ASSIGN(const std::filesystem::path path, path_or(options.markers, "rigs/markers.toml"));
  MIEN_TRY_ASSIGN(const builtin_face::MarkerSet set, builtin_face::read_markers(path));
  MIEN_TRY_ASSIGN(const face::Face face, chosen_face(options.face));
  MIEN_TRY_ASSIGN(const builtin_face::PlacedMarkers placed, builtin_face::PlacedMarkers::place(face, set));
  return mocap::write_marker_track(options.out, mocap::markers_of_motion(motion, placed, set));
}

Result<void> write_onnx(const ExportOptions& options) {
  MIEN_TRY(check_output(options.out, {".onnx"}));
  MIEN_TRY_ASSIGN(const std::vector<std::byte> bytes, onnx::onnx_of_file(options.model, options.graph));
  MIEN_TRY(write_file(options.out, bytes));
  if (options.json)
    print_json({{"out", options.out},
                {"model", options.model},
                {"part", options.graph.part},
                {"steps", options.graph.steps},
                {"bytes", bytes.size()}});
  else
    fmt::print("wrote {}\n", options.out);
  return {};
}

Result<void> write_performance(ExportOptions options) {
  const bool table = wants_markers(options) || std::filesystem::path(options.out).extension() == ".csv";
  if (table && !options.names.empty())
    return fail(ErrorCode::bad_usage, "--names is for the morph targets of glTF", options.out,
                "write a .glb or .gltf, or leave --names out");
  if (table && !options.textures.empty())
    return fail(ErrorCode::bad_usage, "--textures is for glTF", options.out,
                "write a .glb or .gltf, or leave --textures out");
  MIEN_TRY_ASSIGN(const Performance performance, load_performance(options.motion, false));
  if (options.face.empty()) options.face = performance.face.empty() ? "builtin" : performance.face;
  if (wants_markers(options))
    MIEN_TRY(write_markers(performance.motion, options));
  else
    MIEN_TRY(write_motion(performance.motion, options.face, options.out,
                          gltf_names(options.names, options.out), options.textures));
  if (options.json)
    print_json({{"out", options.out},
                {"face", options.face},
                {"frames", performance.motion.frames.size()},
                {"duration_s", performance.motion.duration_s()}});
  else
    fmt::print("wrote {}\n", options.out);
  return {};
}

Result<void> run_export(const ExportOptions& options) {
  std::error_code not_there;
  for (const std::string& read : {options.motion, options.model})
    if (std::filesystem::equivalent(read, options.out, not_there))
      return fail(ErrorCode::bad_usage, "it is what is read, too", options.out, "give --out another name");
  if (options.model.empty() && options.motion.empty())
    return fail(ErrorCode::bad_usage, "--motion or --model is required", "export", "see mien export --help");
  return options.model.empty() ? write_performance(options) : write_onnx(options);
}

}  // namespace

void add_export_command(Commands& commands) {
  auto options = std::make_shared<ExportOptions>();
  const Command command =
      commands.add("export", "Writes a motion as CSV, glTF or markers, or a model as ONNX",
                   "mien export --motion take.mien --names arkit --out take.glb\n  mien export --model "
                   "models/live.safetensors --out live.onnx",
                   [options] { return run_export(*options); });
  const Option motion =
      command.add_option("--motion", options->motion, "A Live Link CSV, or a take, whose truth it is");
  const Option model =
      command.add_option("--model", options->model, "A model file, to write as ONNX (docs/guide/onnx.md)")
          .excludes(motion);
  command
      .add_option("--face", options->face,
                  "For glTF and markers: builtin, a folder with generic_neutral_mesh.obj, or a .glb or .vrm; "
                  "the take's own unless told")
      .needs(motion);
  command
      .add_option("--out", options->out,
                  "The .csv, .glb, .gltf or .vrm to write; .trc for markers; of a model the .onnx")
      .required();
  add_names_option(command, options->names).needs(motion);
  add_textures_option(command, options->textures).needs(motion);
  command
      .add_option("--markers", options->markers,
                  "Write where these markers of the face are, frame H: a marker set as rigs/markers.toml, "
                  "which a .trc takes unless told. A .csv then holds markers too")
      .needs(motion);
  command
      .add_option("--part", options->graph.part,
                  "Of a model: network, ridge.lab or ridge.device; of a headset's eye, mouth or moment "
                  "(default: network)")
      .needs(model);
  command
      .add_option("--chain", options->graph.steps,
                  "Frames that one run of a causal network answers, its states passed on within the graph "
                  "(default: 1)")
      .in_range(std::size_t{1}, onnx::kMostSteps)
      .needs(model);
  command
      .add_flag("--features", options->graph.features,
                "The graph takes what sensors say (m/s^2, quaternions, flags), not the model's normalised "
                "condition")
      .needs(model);
  add_json_flag(command, options->json);
}

}  // namespace mien::app
