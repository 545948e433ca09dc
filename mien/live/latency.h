#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "mien/core/time.h"

namespace mien::live {

/// How long something took, thousands of times: percentiles to 3 %, the largest exactly. No allocation.
class Latencies {
 public:
  void add(Duration took);
  void clear() { *this = {}; }
  [[nodiscard]] std::uint64_t count() const { return count_; }
  /// `share` 0 to 1: 0.5 is the median. Zero while there is none.
  [[nodiscard]] Duration percentile(double share) const;
  [[nodiscard]] Duration largest() const { return largest_; }
  Latencies& operator+=(const Latencies& other);

 private:
  static constexpr std::size_t kBins = 512;  // From 100 ns on, each 3 % wider than the one before.
  std::array<std::uint32_t, kBins> bins_{};
  std::uint64_t count_ = 0;
  Duration largest_{};
};

}  // namespace mien::live
