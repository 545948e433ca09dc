#include "mien/virtual/performance.h"

#include "mien/builtin_face/builtin_face.h"
#include "mien/performer/head_motion.h"
#include "mien/performer/performer.h"
#include "mien/performer/prologue.h"
#include "mien/performer/script.h"
#include "mien/virtual/imu/imu_session.h"

namespace mien::virt {

VirtualPerson draw_person(const Random& root) {
  Random identity = root.fork("identity"), style = root.fork("style");
  return {builtin_face::make_builtin(without_hair(builtin_face::random_identity(identity))),
          performer::draw_style(style)};
}

face::Motion draw_motion(double seconds, const performer::Style& style, const Random& root) {
  Random script = root.fork("script");
  return performer::perform(performer::random_script(seconds, script), style, root.fork("motion"));
}

Result<Performance> perform_with(const Wearing& wearing, const face::Face& face, face::Motion motion,
                                 const sensor::Rig& rig, const Random& random) {
  if (motion.frames.empty()) return fail(ErrorCode::bad_usage, "the motion has no frames", motion.name);
  if (!motion.has_head && !wearing.lab) motion = performer::with_head_motion(motion, random.fork("head"));
  const double placement_mm = wearing.lab ? 0 : wearing.faults.mount_position_mm;
  const std::vector<Vec3> placement_m = draw_placement(rig, 1e-3 * placement_mm, random.fork("placement"));
  Performance out;
  MIEN_TRY_ASSIGN(out.sites, skin_sites(face, rig, placement_m));
  if (wearing.turn_rad > 0) out.sites = draw_turns(out.sites, wearing.turn_rad, random.fork("turns"));
  if (wearing.kinematics)
    out.sites = draw_kinematics(out.sites, *wearing.kinematics, random.fork("kinematics"));
  const performer::PrologueMotion begun = performer::with_prologue(
      motion, performer::PrologueKind::brief, random.fork("prologue"), {.gestures = !wearing.lab});
  if (wearing.lab) {
    MIEN_TRY_ASSIGN(out.session, play_lab(begun, out.sites, rig, random.fork("devices")));
  } else {
    MIEN_TRY_ASSIGN(out.session, play_devices(begun, out.sites, rig, wearing.faults, random.fork("devices")));
  }
  out.begin_s = begun.times.motion_start_s;
  out.end_s = begun.motion.duration_s();
  return out;
}

}  // namespace mien::virt
