#include "mien/virtual/stage.h"

#include <fmt/format.h>

#include <utility>

#include "mien/builtin_face/load_face.h"
#include "mien/core/files.h"
#include "mien/performer/head_motion.h"
#include "mien/performer/performer.h"
#include "mien/performer/style.h"
#include "mien/sensor/rig_part.h"
#include "mien/virtual/eyewear/eyewear_boards.h"
#include "mien/virtual/eyewear/eyewear_session.h"

namespace mien::virt {
namespace {

face::Motion motion_of(const StageRequest& request, const Random& root) {
  if (request.motion) return *request.motion;
  Random style_random = root.fork("style");
  const performer::Style style = performer::draw_style(style_random);
  performer::Script script = request.script;
  script.moves_head = request.devices != "lab";
  return performer::perform(script, style, root.fork("motion"));
}

/// The [faults] table that the request's devices are of, and where it stands; not for *lab*.
struct FaultsText {
  std::string toml;
  std::string where;
};
Result<FaultsText> read_faults(const StageRequest& request, const sensor::Rig& rig) {
  std::error_code code;
  if (request.devices == "device") return FaultsText{rig.faults_toml, request.rig.string()};
  if (!std::filesystem::exists(request.devices, code))
    return fail(ErrorCode::not_found, "there are no such devices", request.devices,
                "name device, lab, or a TOML file of faults");
  MIEN_TRY_ASSIGN(std::string text, read_text(request.devices));
  return FaultsText{std::move(text), request.devices};
}

Result<void> place_on_skin(const StageRequest& request, const face::Face& face, const Random& root,
                           Stage& stage) {
  if (!stage.lab) {
    MIEN_TRY_ASSIGN(const FaultsText faults, read_faults(request, stage.rig));
    MIEN_TRY_ASSIGN(stage.faults, parse_faults(faults.toml, faults.where));
  }
  const std::vector<Vec3> placement_m =
      draw_placement(stage.rig, 1e-3 * stage.faults.mount_position_mm, root.fork("placement"));
  MIEN_TRY_ASSIGN(stage.sites, skin_sites(face, stage.rig, placement_m));
  if (request.unlike > 0)
    stage.sites =
        draw_kinematics(stage.sites, KinematicsSpread().times(request.unlike), root.fork("kinematics"));
  return {};
}

Result<void> put_on_glasses(const StageRequest& request, face::Face face, const Random& root, Stage& stage) {
  if (stage.lab)
    return fail(ErrorCode::bad_usage, "the profile lab is of sensors on the skin, and these look at it",
                stage.rig.name, "use --devices device");
  if (request.unlike > 0)
    return fail(ErrorCode::bad_usage, "only sensors that are glued to it feel how skin turns", stage.rig.name,
                "leave out --unlike");
  MIEN_TRY_ASSIGN(const FaultsText faults, read_faults(request, stage.rig));
  WornEyewear& worn = stage.eyewear.emplace();
  MIEN_TRY_ASSIGN(worn.faults, parse_eyewear_faults(faults.toml, faults.where));
  MIEN_TRY_ASSIGN(worn.wearer, seat_eyewear(std::move(face), stage.rig, worn.faults, root.fork("wearer")));
  return {};
}

}  // namespace

Result<Stage> set_stage(const StageRequest& request) {
  Stage stage;
  MIEN_TRY_ASSIGN(stage.rig_toml, read_text(request.rig));
  MIEN_TRY_ASSIGN(stage.rig, sensor::parse_rig(stage.rig_toml, request.rig.string()));
  const std::vector<std::string> kinds = sensor::kinds_of(stage.rig);
  if (kinds.size() == 1 && kinds.front() != "imu" && kinds.front() != "eyewear")
    return fail(ErrorCode::unsupported, "there are no virtual sensors of the kind " + kinds.front(),
                request.rig.string(), "use a rig of the kind imu or eyewear");
  if (kinds.size() > 1)
    return fail(ErrorCode::unsupported, "no virtual performer wears sensors of several kinds at once",
                request.rig.string(), "perform each kind with a rig of its own, to one session that has all");
  stage.lab = request.devices == "lab";
  MIEN_TRY_ASSIGN(face::Face face, builtin_face::load_face(request.face));
  const Random root(request.seed);
  if (is_eyewear(stage.rig))
    MIEN_TRY(put_on_glasses(request, std::move(face), root, stage));
  else
    MIEN_TRY(place_on_skin(request, face, root, stage));

  const double seconds = request.motion ? request.motion->duration_s() : request.script.duration_s();
  if (!(seconds <= kLongestPerformanceS))
    return fail(
        ErrorCode::out_of_range,
        fmt::format("the performance is {:.0f} s long, more than {:.0f}", seconds, kLongestPerformanceS),
        request.script_name, "perform it in parts; a time code may jump");
  face::Motion motion = motion_of(request, root);
  if (motion.frames.empty())
    return fail(ErrorCode::bad_usage, "the motion has no frames", request.script_name);
  if (!motion.has_head && !stage.lab) motion = performer::with_head_motion(motion, root.fork("head"));
  const performer::PrologueNeeds needs =
      stage.eyewear ? performer::kEyewearPrologue : performer::PrologueNeeds{.gestures = !stage.lab};
  stage.motion = performer::with_prologue(motion, request.prologue, root.fork("prologue"), needs);
  stage.devices = root.fork("devices");
  return stage;
}

Result<VirtualSession> play(const Stage& stage, const Progress& progress) {
  if (stage.eyewear)
    return play_eyewear(stage.motion, stage.eyewear->wearer, stage.rig, stage.eyewear->faults, stage.devices);
  if (stage.lab) return play_lab(stage.motion, stage.sites, stage.rig, stage.devices);
  return play_devices(stage.motion, stage.sites, stage.rig, stage.faults, stage.devices, progress);
}

}  // namespace mien::virt
