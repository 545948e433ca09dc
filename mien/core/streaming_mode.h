#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "mien/core/time.h"

namespace mien {

/// The most frequent value of the newest 30 s of a 60 Hz signal in [0, 1], from a histogram that takes one
/// value in and the oldest out. Bin k of 64 holds the values nearest to k/63, so that 0 and 1 are told
/// without rounding. No allocation; add() is O(1), the others O(kBins). 2 KB.
class StreamingMode {
 public:
  static constexpr std::size_t kBins = 64;
  /// Values in the window: 30 s of the 60 Hz grid.
  static constexpr std::size_t kWindow = static_cast<std::size_t>(30 * kFrameRateHz);

  /// Takes a value, held to [0, 1]; the oldest of a full window goes. One that is not finite changes nothing.
  void add(float value);
  /// The highest bin of the histogram smoothed by 1-2-1 (the lowest of several), refined by the parabola
  /// through it and its neighbours, in [0, 1]; beyond both ends the histogram is 0. In the outermost bins it
  /// is 0 and 1, where values that are held to their range pile up. A value seen alone is told within 1/126.
  /// 0 while there is no value.
  [[nodiscard]] double mode() const;
  /// The value that `share` (0 to 1) of the window exceeds, in [0, 1], linear within a bin. 0 while there is
  /// no value.
  [[nodiscard]] double upper(double share) const;
  /// How many values there are, at most kWindow.
  [[nodiscard]] std::size_t count() const { return count_; }
  void reset();

 private:
  [[nodiscard]] int smoothed(int bin) const;

  std::array<std::uint8_t, kWindow>
      ring_{};  // Bins in the order in which they came, from next_ on once full.
  std::array<std::uint16_t, kBins + 4> counts_{};  // With two empty bins beyond each end.
  std::uint16_t count_ = 0;
  std::uint16_t next_ = 0;
};

}  // namespace mien
