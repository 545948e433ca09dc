#pragma once

#include <algorithm>

#include "mien/core/time.h"

namespace mien::live {

/// What may be used at a rate, of which a second's worth may come at once: datagrams, pictures, bytes.
struct Budget {
  double tokens = 0;
  HostTime refilled;

  /// Takes `amount` where it is there, which it is sooner or later only if it is no more than a second's.
  /// `rate`: a second.
  [[nodiscard]] bool spend(HostTime now, double rate, double amount = 1) {
    // The clock begins anew when the session does, after its ports were opened.
    tokens = std::min(rate, tokens + rate * to_seconds(std::max(now - refilled, Duration{})));
    refilled = now;
    if (tokens < amount) return false;
    tokens -= amount;
    return true;
  }
};

}  // namespace mien::live
