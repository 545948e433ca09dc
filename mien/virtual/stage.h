#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/core/wav.h"
#include "mien/face/motion.h"
#include "mien/performer/long_motion.h"
#include "mien/performer/prologue.h"
#include "mien/performer/script.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/headset/timed_failure.h"
#include "mien/virtual/phone/phone_faults.h"
#include "mien/virtual/session.h"
#include "mien/virtual/worn_devices.h"

namespace mien::virt {

/// The longest performance, s.
inline constexpr double kLongestPerformanceS = 10800;
/// And of what is held whole, s: two hours take three gigabytes (lab) to eight (IMUs and a microphone).
inline constexpr double kLongestWholeS = 7200;

/// What is performed, on whose skin and through which devices, wherever it goes.
struct StageRequest {
  performer::Script script;  ///< What a virtual performer plays, ...
  /// ... and then. `script` and each of these but the last are performer::kPieceS long.
  std::vector<performer::Script> later_scripts;
  std::optional<face::Motion> motion;  ///< Performed in place of scripts.
  std::optional<double> motion_s;      ///< The motion is repeated, or cut, to last so long, s.
  std::string script_name;             ///< The block, or the motion's file; for people.
  std::optional<Sound> sound;          ///< What is heard with it, from its start.
  std::string face = "builtin";        ///< As face::load_face takes it.
  std::filesystem::path rig;           ///< Rig file.
  std::string devices = "device";      ///< "device": the rig's own faults; "lab"; or a TOML file of faults.
  /// How unlike the face's own the wearer's skin is under IMUs: 1 draws what every shape does to it
  /// KinematicsSpread's 30 % and 15 degrees off, 0 leaves it as the face has it.
  double unlike = 0;
  std::optional<TimedFailure> headset_failure;  ///< What befalls its cameras.
  /// A phone looks on and is recorded as a truth, where the rig has no sensor for one.
  bool phone = false;
  /// What the phone is like, in every profile; none: as `devices` say.
  std::optional<PhoneFaults> phone_faults;
  std::uint64_t seed = 1;
  performer::PrologueKind prologue = performer::PrologueKind::brief;
};

/// Everything that a performance needs, read and drawn: the same request gives the same stage.
struct Stage {
  std::string rig_toml;  ///< The rig file, whole; with a phone that the request adds, written anew.
  sensor::Rig rig;
  bool lab = false;  ///< The profile *lab*: there are no faults then.
  /// IMUs and cameras are worn at once: the faults of cameras stand in a table of their own.
  bool together = false;
  std::shared_ptr<const WornDevices> worn;  ///< All that the rig has; never null when set.
  performer::PrologueMotion motion;         ///< Whole; on a stage that is streamed its first piece.
  /// How the motion goes on after that, or is repeated; neither: it is whole.
  std::optional<performer::LaterPieces> later;
  std::optional<performer::Encore> encore;
  double duration_s = 0;       ///< Of the motion with its prologue, also where it is not whole.
  Random devices = Random(0);  ///< What the devices' faults are drawn from.
};

/// A [faults] table, and where it stands.
struct FaultsText {
  std::string toml;
  std::string where;
  bool stated = true;  ///< False where that table is not there; the text is empty then.
};
/// The faults that the request's devices are of: the rig's own, or a file's. Not for *lab*. `table`: those of
/// devices that have a table of their own in it ("microphone", for [faults.microphone]; "headset", "phone");
/// empty: all that stands in none. Errors: not_found, malformed.
[[nodiscard]] Result<FaultsText> read_faults(const StageRequest& request, const sensor::Rig& rig,
                                             std::string_view table = {});

/// How much of a long performance a stage holds.
enum class StageHolds {
  whole,
  piece,  ///< The first piece, where the devices can be streamed: for stream() alone.
};

/// Reads rig, faults and face, draws the performer and places the sensors. Errors: those of the readers;
/// not_found (no such devices); bad_usage (eyewear or cameras in the profile *lab*, or on skin unlike
/// the face's; a headset's failure without one; a microphone, a phone, or a camera beside IMUs, that is the
/// reference); unsupported (several kinds at once but for cameras beside IMUs, microphones and a phone);
/// out_of_range (too long; a failure that begins when it is over).
[[nodiscard]] Result<Stage> set_stage(const StageRequest& request, StageHolds holds = StageHolds::whole);

/// The motion on its stage.
[[nodiscard]] performer::LongMotion long_motion(const Stage& stage);

/// The whole performance on its stage, as a session with the rig receives it; `progress` hears of devices'.
/// Errors: those of WornDevices::send().
[[nodiscard]] Result<VirtualSession> play(const Stage& stage, const Progress& progress = no_progress);

/// The same stretch by stretch, or where its devices cannot be streamed in one. The stage outlives it.
/// Errors: those of WornDevices::stream().
[[nodiscard]] Result<std::unique_ptr<SessionStream>> stream(const Stage& stage);

}  // namespace mien::virt
