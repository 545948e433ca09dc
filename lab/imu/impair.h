#pragma once

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/imu/device_trouble.h"
#include "mien/virtual/imu/imu_session.h"
#include "mien/virtual/network.h"

namespace mien::lab {

/// The same performance as it would have been heard through a worse network, from devices in trouble: new
/// entries, samples and ticks (by sensor::TickRule again), and the truth at the new ticks' moments. What the
/// session's arrivals say is when datagrams are sent into that network.
///
/// Truth and events stand where they stood while the reference sensor's clock is its own, and go along with
/// it where it is in trouble. Where it is not heard at the beginning the line is the host's: they are brought
/// there by the old session's clock model, to about a millisecond. Ticks beyond the old session's first and
/// last frame have a truth that is not evaluated. `session` comes from virt::play_devices() on this rig.
/// Errors: virt::deliver()'s and virt::trouble_devices()'s; bad_usage (a session without truth).
[[nodiscard]] Result<virt::VirtualSession> impair(const virt::VirtualSession& session, const sensor::Rig& rig,
                                                  const virt::NetworkSettings& settings, const Random& random,
                                                  const virt::DeviceTroubles& troubles = {});

}  // namespace mien::lab
