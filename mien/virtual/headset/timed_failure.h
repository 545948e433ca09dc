#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "mien/core/error.h"

namespace mien::virt {

enum class HeadsetFailure : std::uint8_t;  // headset_simulator.h

/// A headset's failure, and when it happens.
struct TimedFailure {
  HeadsetFailure failure{};
  /// Seconds from the motion's start, after the prologue. None: from the beginning, in the prologue too, or
  /// to the end.
  std::optional<double> from_s, to_s;
  bool operator==(const TimedFailure&) const = default;
};

/// "hand" (always), "hand@4-9" (from 4 to 9 s), "hand@4-" (from 4 s on): as people write it. Errors:
/// bad_usage (no such failure, or no such times).
[[nodiscard]] Result<TimedFailure> parse_timed_failure(std::string_view text);

}  // namespace mien::virt
