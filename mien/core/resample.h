#pragma once

#include <cstdint>

#include "mien/core/wav.h"

namespace mien {

/// The sound at another rate, neither earlier nor later: sample i is what is heard at i / rate_hz,
/// band-limited to 0.45 of the lower rate (a sinc of 32 zero crossings under Blackman's window, 74 dB down).
/// Beyond both ends is silence. A sound of that rate comes back as it is; one whose rate is 0, empty. Cost:
/// an hour from 16 to 8 kHz a few seconds of one core.
[[nodiscard]] Sound resampled(const Sound& sound, std::uint32_t rate_hz);

}  // namespace mien
