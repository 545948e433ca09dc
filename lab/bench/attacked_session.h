#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/child_program.h"
#include "lab/bench/attack.h"
#include "lab/bench/hostile_camera.h"
#include "lab/columns.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/measure/metrics.h"
#include "mien/virtual/session.h"
#include "mien/virtual/stage.h"

namespace mien::lab {

/// What a session came to, beside its devices and perhaps a stranger. What is said of frames and readings is
/// of the time in which the motion is performed, from its first frame that is evaluated to its last.
struct AttackFigures {
  double frames = 0;              ///< Of the whole session.
  double missed = 0;              ///< Of the whole session.
  double added = 0;               ///< Frames beyond sixty a second; negative: too few.
  double p50_ms = 0, p99_ms = 0;  ///< As `mien live` has them.
  double peak_memory_mb = 0;      ///< Of the session's process.
  double dropped = 0, evicted = 0, malformed = 0;
  double heard = 0;              ///< Readings of the devices that were accepted.
  double strangers = 0;          ///< Readings of the stranger that were accepted.
  std::optional<double> pve_mm;  ///< Of what was shown at each moment, against the performer's truth.
  double sent = 0;               ///< Datagrams of the stranger.
  bool same_bits = false;        ///< Its take replays to the session's hash.
};
[[nodiscard]] const Columns<AttackFigures>& attack_columns();
/// What a session said of itself at its end (`mien live --json`), and its hash. Errors: internal (it failed).
[[nodiscard]] Result<std::string> read_summary(const app::ChildOutput& said, AttackFigures& out);

/// What sessions are attacked in: one performance, the same in each.
struct AttackScene {
  virt::Stage stage;
  virt::VirtualSession played;            ///< What a session would see of it.
  std::string rig, model;                 ///< Files.
  std::unique_ptr<measure::Meter> meter;  ///< None: faces are not compared.
  double rate = 1;                        ///< Share of each attack's own.
  std::uint64_t seed = 1;
};

struct SceneRequest {
  double seconds = 20;     ///< Of the motion.
  double still_s = 6;      ///< That the performer sits still first, with the devices on.
  bool calibrated = true;  ///< With a prologue; else the face stays neutral, and is not compared.
  std::string rig, model;
  double rate = 1;
  std::uint64_t seed = 1;
};
/// Errors: the stage's, and the face's.
[[nodiscard]] Result<AttackScene> set_attack_scene(const SceneRequest& request);

/// The performer's boards.
struct Boards {
  virt::NodeLanguage language = virt::NodeLanguage::mien;
  bool keyed = false;  ///< They and the session are paired.
};

/// Runs `mien live` as a process of its own, performs for it through real sockets, and attacks it meanwhile;
/// nobody does where there is no attack. The session is asked to end after the performance. Errors: the
/// performance's; io (the session did not end); internal (it failed); cancelled.
[[nodiscard]] Result<AttackFigures> run_attacked_session(const AttackScene& scene, const Attack* attack,
                                                         const Boards& boards, const Progress& progress);

/// What sessions of cameras are attacked in.
struct CameraScene {
  std::string rig, model;  ///< Files.
  double seconds = 20;
  std::uint64_t seed = 1;
  Pictures pictures;  ///< What good cameras show.
};
/// `model` empty: the one of the rig. Errors: those of reading the rig; not_found (there is no model).
[[nodiscard]] Result<CameraScene> set_camera_scene(double seconds, const std::string& model,
                                                   std::uint64_t seed);

/// Runs `mien live` as a process of its own on three cameras of a headset, of which the second is hostile;
/// where there is no attack it is as good as the others. Figures are of `seconds` from two seconds after the
/// first picture on; `heard` are the good cameras' pictures that were accepted, the first's and the third's,
/// `sent` the hostile camera's bytes. What the second says is believed where it is a picture, as any
/// camera's is, and not counted. Errors: io (the session asks for no pictures, or did not end); internal (it
/// failed); cancelled.
[[nodiscard]] Result<AttackFigures> run_attacked_cameras(const CameraScene& scene, const Attack* attack,
                                                         const Progress& progress);

/// Each figure's median over runs; `same_bits` where all had it. The PVE is that of the runs that have one.
[[nodiscard]] AttackFigures median(const std::vector<AttackFigures>& runs);

/// What a stranger brought about that he must not, each in a few words; empty: nothing. `quiet` are the same
/// sessions without him. Limits: no reading of his is accepted, the face is shown as without him (the PVE
/// within 2 %, or the runs' own spread where that is more) and the devices are heard (99 of 100 readings, of
/// cameras all but a tenth of a second where that is more); no frame added; at most 40 MB more memory, which
/// is what the queues of a recording hold; its take replays to the same bits. Where the face is compared,
/// time is judged too: no frame missed that is not missed without him; p99 at most a millisecond more, with a
/// key no more than the runs' own spread or 0.2 ms. Of one who behaves as a sensor and speaks first, without
/// a key: all but whom the face is of. Of a camera: no frame is missing either, and what it shows is nobody
/// else's.
[[nodiscard]] std::vector<std::string> breaches(const Attack& attack, bool keyed,
                                                const std::vector<AttackFigures>& attacked,
                                                const std::vector<AttackFigures>& quiet);

}  // namespace mien::lab
