#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>

#include "app/camera_import.h"
#include "app/command.h"
#include "app/json_output.h"
#include "app/live/session_markers.h"
#include "app/marker_import.h"
#include "app/write_motion.h"
#include "mien/core/excerpt.h"
#include "mien/core/files.h"
#include "mien/face/livelink_csv.h"
#include "mien/mocap/load_marker_track.h"
#include "mien/take/take.h"

namespace mien::app {
namespace {

struct ImportOptions {
  std::string motion, take, out, performer = "unknown", rig;
  MarkerImport markers;
  CameraImport cameras;
  bool force = false;
  bool json = false;
};

/// All but the rig.
take::Header header_of(const ImportOptions& options, const std::string& script, const std::string& face) {
  take::Header header;
  header.software = "mien " MIEN_VERSION;
  header.performer = options.performer;
  header.script = script;
  header.devices = "none";
  header.face = face;
  header.prologue = "none";
  header.created_utc = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  return header;
}

/// Writes the motion as a take's truth.
Result<void> write_take(const ImportOptions& options, const face::Motion& motion, const std::string& face) {
  MIEN_TRY_ASSIGN(const std::filesystem::path rig, path_or(options.rig, "rigs/default.toml"));
  take::Header header = header_of(options, std::filesystem::path(options.motion).filename().string(), face);
  MIEN_TRY_ASSIGN(header.rig_toml, read_text(rig));
  MIEN_TRY_ASSIGN(take::TakeWriter writer, take::TakeWriter::create(options.take, header, options.force,
                                                                    take::Appears::when_finished));
  const Progress progress = terminal_progress("import");
  std::size_t written = 0;
  for (const face::MotionFrame& frame : motion.frames) {
    if (!progress(static_cast<double>(written++) / static_cast<double>(motion.frames.size()), "writing"))
      return fail(ErrorCode::cancelled, "stopped", options.take, "nothing was kept");
    take::TruthFrame truth;
    truth.time = DeviceTime(from_seconds(frame.time_s));
    truth.weights = frame.weights;
    truth.tongue_out = frame.tongue_out;
    truth.has_face = frame.has_face;
    writer.add_truth(truth);
  }
  MIEN_TRY(writer.finish());
  progress(1, "written");
  return {};
}

/// A take of recorded pictures, beside the motion's truth where there is one.
Result<void> run_cameras(const ImportOptions& options) {
  if (options.take.empty() == options.out.empty())
    return fail(ErrorCode::bad_usage,
                options.out.empty() ? "nothing to write" : "a take of pictures has one name", "mien import",
                "give --out TAKE.mien");
  const std::string& path = options.out.empty() ? options.take : options.out;
  MIEN_TRY(check_output(path, {".mien"}));
  MIEN_TRY_ASSIGN(const std::filesystem::path rig, path_or(options.rig, "rigs/headset.toml"));
  std::optional<face::Motion> truth;
  if (!options.motion.empty()) {
    std::vector<std::string> warnings;
    MIEN_TRY_ASSIGN(truth, face::load_motion(options.motion, &warnings));
    for (const std::string& warning : warnings)
      fmt::print(stderr, "mien: {}: {}\n", options.motion, without_controls(warning));
  }
  std::string script = "pictures";
  if (truth) script = std::filesystem::path(options.motion).filename().string();
  MIEN_TRY_ASSIGN(const ImportedPictures imported,
                  import_pictures(options.cameras, rig, header_of(options, script, options.markers.face),
                                  truth ? &*truth : nullptr, path, options.force));
  if (options.json) {
    print_json({{"take", path},
                {"cameras", pictures_json(imported)},
                {"frames", imported.frames},
                {"truth", imported.truth},
                {"events", imported.events},
                {"duration_s", imported.seconds}});
    return {};
  }
  fmt::print("{}: {:.1f} s, {} frames, {} with truth, {} events\n{}", path, imported.seconds, imported.frames,
             imported.truth, imported.events, pictures_text(imported));
  return {};
}

Result<void> run_import(const ImportOptions& options) {
  if (!options.cameras.cameras.empty()) return run_cameras(options);
  if (options.motion.empty())
    return fail(ErrorCode::bad_usage, "nothing to import", "mien import",
                "name a recorded motion, or what cameras recorded: --camera eye_L=FOLDER");
  if (options.take.empty() && options.out.empty())
    return fail(ErrorCode::bad_usage, "nothing to write", "mien import",
                "give --take FILE.mien, --out FILE, or both");
  if (!options.take.empty()) MIEN_TRY(check_output(options.take, {".mien"}));
  if (!options.out.empty()) MIEN_TRY(check_motion_output(options.out));
  std::vector<std::string> warnings;
  std::optional<ImportedMarkers> markers;
  std::optional<take::Take> session;
  DeviceTime begin;
  face::Motion motion;
  if (std::filesystem::path(options.motion).extension() == ".mien") {
    MIEN_TRY_ASSIGN(session, take::Take::open(options.motion));
    MIEN_TRY_ASSIGN(SessionMarkers found, session_markers(*session, options.markers));
    begin = found.begin;
    if (found.unnamed > 0)
      warnings.push_back(fmt::format("{} frames of markers without names are left out", found.unnamed));
    markers = std::move(found.imported);
    motion = std::move(markers->retargeted.motion);
  } else if (const auto extension = std::filesystem::path(options.motion).extension();
             extension == ".trc" || extension == ".c3d" || mocap::is_marker_recording(options.motion)) {
    MIEN_TRY_ASSIGN(const mocap::MarkerTrack track, mocap::load_marker_track(options.motion, &warnings));
    MIEN_TRY_ASSIGN(markers, import_markers(track, options.markers));
    motion = std::move(markers->retargeted.motion);
  } else {
    MIEN_TRY_ASSIGN(motion, face::load_motion(options.motion, &warnings));
  }
  for (const std::string& warning : warnings)
    fmt::print(stderr, "mien: {}: {}\n", options.motion, without_controls(warning));
  if (!options.take.empty() && session)
    MIEN_TRY(write_with_truth(*session, motion, begin, options.markers.face, options.take, options.force));
  else if (!options.take.empty())
    MIEN_TRY(write_take(options, motion, options.markers.face));
  if (!options.out.empty()) MIEN_TRY(write_motion(motion, options.markers.face, options.out));

  const auto lost =
      static_cast<std::size_t>(std::ranges::count(motion.frames, false, &face::MotionFrame::has_face));
  if (options.json) {
    nlohmann::json json = {{"take", options.take},
                           {"out", options.out},
                           {"frames", motion.frames.size()},
                           {"lost", lost},
                           {"duration_s", motion.duration_s()}};
    if (markers) json["markers"] = markers_json(*markers);
    print_json(json);
    return {};
  }
  for (const std::string& path : {options.take, options.out})
    if (!path.empty())
      fmt::print("{}: {:.1f} s, {} frames of truth, {} without a face\n", path, motion.duration_s(),
                 motion.frames.size(), lost);
  if (markers) fmt::print("{}", markers_text(*markers));
  return {};
}

}  // namespace

void add_import_command(Commands& commands) {
  auto options = std::make_shared<ImportOptions>();
  const Command command = commands.add(
      "import", "Makes a take of recorded motion, markers or camera pictures",
      "mien import MySlate_3.csv --take alex.mien\n"
      "  mien import --camera eye_L=left/ --camera eye_R=right.mp4 --fps 25 --rig rigs/headset.toml "
      "--out eyes.mien",
      [options] { return run_import(*options); });
  command.add_option("motion", options->motion,
                     "A Live Link Face CSV; 3-D markers: .csv (ours or Motive's), .trc, .c3d; or a recorded "
                     "session (.mien) into which a motion capture server sent its markers. Of cameras' "
                     "pictures the CSV is their truth, from the first picture on, and may be missing");
  command.add_option("--take", options->take, "The take to write");
  command.add_option("--out", options->out,
                     "Write the weights: .csv (Live Link Face), .glb or .gltf; of cameras the take: .mien");
  command.add_option("--performer", options->performer, "Who performed").show_default();
  command.add_option("--rig", options->rig,
                     "Which sensors were worn (default: rigs/default.toml; of cameras rigs/headset.toml)");
  options->markers.add_to(command);
  options->cameras.add_to(command);
  command.add_flag("--force", options->force, "Replace an existing take");
  add_json_flag(command, options->json);
}

}  // namespace mien::app
