#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "mien/core/error.h"
#include "mien/performer/prologue.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/rig.h"
#include "mien/session/session.h"
#include "mien/virtual/network.h"
#include "mien/virtual/session.h"
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

/// The device that a virtual board of each sensor of the rig is: the one to which the rig binds it, or the
/// virtual node of its place where the rig binds none. Errors: bad_usage (the rig binds some sensors and not
/// others), sensor::bindings'.
[[nodiscard]] Result<std::vector<sensor::DeviceKey>> virtual_devices(const sensor::Rig& rig);

}  // namespace mien::virt
