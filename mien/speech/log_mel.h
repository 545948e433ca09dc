#pragma once

#include <array>
#include <cstddef>
#include <memory>

#include "mien/speech/sound_block.h"

namespace mien::speech {

inline constexpr std::size_t kMelBands = 40;

/// One frame: natural logarithm of each band's power; kLogFloor at least. A sine of full scale gives 0 in the
/// bin of the transform that it is in, and so up to 0.65 in its band.
using MelFrame = std::array<float, kMelBands>;

/// Log-mel spectrum of a stream of blocks: Hann windows of 25 ms every 10 ms, 512-point transform, 40
/// triangular bands of equal width on the mel scale (2595 lg(1 + f / 700 Hz)) from 60 to 7,600 Hz. A frame
/// ends with the newest sample, so its middle lies 12.5 ms before. A pure function of the blocks. No
/// allocation after the first block.
class LogMel {
 public:
  static constexpr double kLowest_hz = 60, kHighest_hz = 7'600;
  /// Power of -80 dB: below a quiet room's in any band.
  static constexpr float kLogFloor = -18.42F;

  LogMel();
  ~LogMel();
  LogMel(LogMel&&) noexcept;
  LogMel& operator=(LogMel&&) noexcept;

  [[nodiscard]] std::array<MelFrame, kFramesPerBlock> push(const Block& block);
  /// As after construction: silence before the first block.
  void reset();

 private:
  struct Transform;
  std::unique_ptr<Transform> transform_;
};

}  // namespace mien::speech
