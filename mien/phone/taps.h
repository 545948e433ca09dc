#pragma once

#include <optional>
#include <span>

#include "mien/face/motion.h"
#include "mien/model/features.h"
#include "mien/phone/time_alignment.h"

namespace mien::phone {

/// A first guess at where a phone's time is on the sensors', by a finger that tapped the chin three times,
/// 0.2 to 0.8 s apart and in the same rhythm for both: seen by whichever sensor felt it most, anywhere in
/// `skin` (where accelerations are known, after the calibration), and in the jaw or the head of what was told
/// within its first or last 30 s. None where either shows no such three, or where they fit at several
/// offsets. A pure function; arguments as align()'s. Cost: a few milliseconds a minute.
[[nodiscard]] std::optional<AlignmentPrior> prior_by_taps(std::span<const model::FeatureFrame> skin,
                                                          const face::Motion& told);

}  // namespace mien::phone
