#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/motion.h"
#include "mien/performer/prologue.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/rig.h"
#include "mien/session/session.h"
#include "mien/take/take.h"
#include "mien/virtual/network.h"
#include "mien/virtual/session.h"
#include "mien/virtual/virtual_clock.h"
#include "mien/virtual/worn_devices.h"

namespace mien::virt {

/// Where virtual devices' datagrams arrive: received by a session without trackers, and written down as its
/// log would be. What does not parse is logged and nothing more. Entries are numbered on from call to call,
/// so a session may be taken stretch by stretch.
class Reception {
 public:
  /// Errors: modalities::make_receiving_session's.
  [[nodiscard]] static Result<Reception> create(const sensor::Rig& rig);

  /// One datagram: its entry, and its samples.
  void log(Datagram datagram, VirtualSession& session);
  /// All of them and the ticks between. Shape: `arrived` by arrival. `on_tick` is called at every tick, with
  /// the time lines as they are then.
  void log_all(std::vector<Datagram> arrived, VirtualSession& session,
               const std::function<void(const take::Tick&, const sensor::TimeLines&)>& on_tick);

 private:
  explicit Reception(std::unique_ptr<session::Session> session) : session_(std::move(session)) {}

  std::unique_ptr<session::Session> session_;
  std::int64_t entries_ = 0;
};

/// The whole performance as a session of this rig receives it. Errors: Reception::create's.
[[nodiscard]] Result<VirtualSession> receive_all(Sent sent, const performer::PrologueMotion& motion,
                                                 const sensor::Rig& rig);

/// The prologue as a take's events, on the reference's clock: "neutral", "nod", "shake", "range" (all of
/// the prompts), "prompt", "ease"; steps that were left out have none.
[[nodiscard]] std::vector<take::Event> prologue_events(const performer::PrologueTimes& times,
                                                       const VirtualClock& reference);

/// What is performed at a frame's true time; evaluated from the motion's own start to its last frame.
[[nodiscard]] take::TruthFrame truth_of(const face::MotionFrame& moment, double true_s, double motion_start_s,
                                        double duration_s, DeviceTime frame);

/// Frames stand on whole nanoseconds, a motion's own times do not: nearer than this they are one moment, s.
inline constexpr double kSameMomentS = 1e-6;

/// A performance as a curve. Errors: bad_usage (it has no frames).
[[nodiscard]] Result<face::MotionCurve> curve_of(const performer::PrologueMotion& motion);

/// The device that a virtual board of each sensor of the rig is: the one to which the rig binds it, or the
/// virtual node of its place where the rig binds none. Errors: bad_usage (the rig binds some sensors and not
/// others), sensor::bindings'.
[[nodiscard]] Result<std::vector<sensor::DeviceKey>> virtual_devices(const sensor::Rig& rig);

}  // namespace mien::virt
