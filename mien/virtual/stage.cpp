#include "mien/virtual/stage.h"

#include <fmt/format.h>

#include "mien/core/files.h"
#include "mien/face/load.h"
#include "mien/virtual/head_motion.h"
#include "mien/virtual/performer.h"
#include "mien/virtual/style.h"

namespace mien::virt {
namespace {

face::Motion motion_of(const StageRequest& request, const Random& root) {
  if (request.motion) return *request.motion;
  Random style_random = root.fork("style");
  const Style style = draw_style(style_random);
  Script script = request.script;
  script.moves_head = request.devices != "lab";
  return perform(script, style, root.fork("motion"));
}

}  // namespace

Result<Stage> set_stage(const StageRequest& request) {
  std::error_code code;
  Stage stage;
  MIEN_TRY_ASSIGN(stage.rig_toml, read_text(request.rig));
  MIEN_TRY_ASSIGN(stage.rig, sensor::parse_rig(stage.rig_toml, request.rig.string()));
  stage.lab = request.devices == "lab";
  if (request.devices == "device") {
    MIEN_TRY_ASSIGN(stage.faults, parse_faults(stage.rig.faults_toml, request.rig.string()));
  } else if (!stage.lab) {
    if (!std::filesystem::exists(request.devices, code))
      return fail(ErrorCode::not_found, "there are no such devices", request.devices,
                  "name device, lab, or a TOML file of faults");
    MIEN_TRY_ASSIGN(const std::string text, read_text(request.devices));
    MIEN_TRY_ASSIGN(stage.faults, parse_faults(text, request.devices));
  }
  MIEN_TRY_ASSIGN(const face::Face face, face::load_face(request.face));
  const Random root(request.seed);
  const std::vector<Vec3> placement_m =
      draw_placement(stage.rig, 1e-3 * stage.faults.mount_position_mm, root.fork("placement"));
  MIEN_TRY_ASSIGN(stage.sites, skin_sites(face, stage.rig, placement_m));

  const double seconds = request.motion ? request.motion->duration_s() : request.script.duration_s();
  if (!(seconds <= kLongestPerformanceS))
    return fail(
        ErrorCode::out_of_range,
        fmt::format("the performance is {:.0f} s long, more than {:.0f}", seconds, kLongestPerformanceS),
        request.script_name, "perform it in parts; a time code may jump");
  face::Motion motion = motion_of(request, root);
  if (motion.frames.empty())
    return fail(ErrorCode::bad_usage, "the motion has no frames", request.script_name);
  if (!motion.has_head && !stage.lab) motion = with_head_motion(motion, root.fork("head"));
  stage.motion = with_prologue(motion, request.prologue, root.fork("prologue"), !stage.lab);
  stage.devices = root.fork("devices");
  return stage;
}

}  // namespace mien::virt
