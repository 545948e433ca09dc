#pragma once

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/performer/prologue.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/eyewear/eyewear_faults.h"
#include "mien/virtual/eyewear/eyewear_wearer.h"
#include "mien/virtual/session.h"
#include "mien/virtual/worn_devices.h"

namespace mien::virt {

/// What the boards of smart eyewear send of a performance. The face is the wearer's. Errors: bad_usage (a
/// motion without frames), those of EyewearBoards. Cost: about a second of one core for ten of performance.
[[nodiscard]] Result<Sent> send_eyewear(const performer::PrologueMotion& motion, const EyewearWearer& wearer,
                                        const sensor::Rig& rig, const EyewearFaults& faults,
                                        const Random& random);

/// Everything that a live session would have seen of a wearer who performs with smart eyewear on: as
/// play_devices() has it of IMUs. Errors and cost: those of send_eyewear().
[[nodiscard]] Result<VirtualSession> play_eyewear(const performer::PrologueMotion& motion,
                                                  const EyewearWearer& wearer, const sensor::Rig& rig,
                                                  const EyewearFaults& faults, const Random& random);

}  // namespace mien::virt
