#pragma once

#include <vector>

#include "mien/core/progress.h"
#include "mien/performer/prologue.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/imu/device_faults.h"
#include "mien/virtual/imu/skin_site.h"
#include "mien/virtual/session.h"
#include "mien/virtual/worn_devices.h"

namespace mien::virt {

/// White noise of the lab profile, an axis: 1 degree.
inline constexpr double kLabNoiseRad = 0.017453292519943295;

/// What they send, of play_devices() and of play_lab(): errors as theirs.
[[nodiscard]] Result<Sent> send_devices(const performer::PrologueMotion& motion,
                                        const std::vector<SkinSite>& sites, const sensor::Rig& rig,
                                        const DeviceFaults& faults, const Random& random,
                                        const Progress& progress);
[[nodiscard]] Result<Sent> send_lab(const performer::PrologueMotion& motion,
                                    const std::vector<SkinSite>& sites, const sensor::Rig& rig,
                                    const Random& random, double noise_rad = kLabNoiseRad);

/// The *device* profile: each sensor is a node of its own that sends raw axes at 240 Hz, four samples a
/// packet, with the faults that `random` draws it. `sites` are those of the rig's sensors, in its order.
/// Errors: bad_usage (a motion without frames), cancelled, and what the packets' encoder finds.
[[nodiscard]] Result<VirtualSession> play_devices(const performer::PrologueMotion& motion,
                                                  const std::vector<SkinSite>& sites, const sensor::Rig& rig,
                                                  const DeviceFaults& faults, const Random& random,
                                                  const Progress& progress = no_progress);

/// The *lab* profile: for each face sensor and each frame of 60 Hz one rotation vector of the skin in the
/// head frame, with white noise; no acceleration, no ear sensor, and all clocks are one.
[[nodiscard]] Result<VirtualSession> play_lab(const performer::PrologueMotion& motion,
                                              const std::vector<SkinSite>& sites, const sensor::Rig& rig,
                                              const Random& random, double noise_rad = kLabNoiseRad);

}  // namespace mien::virt
