#pragma once

#include <cstddef>

namespace mien::model {

/// Channels of a picture's convolution come in this many at a time.
inline constexpr std::size_t kPictureChannels = 16;

/// One line of a convolution of one channel: `count` pixels of `channels` numbers each, a multiple of
/// kPictureChannels, next to each other.
struct PictureLine {
  const float* x = nullptr;  ///< The upper left of the first pixel's nine.
  std::size_t line = 0;      ///< Numbers from line to line.
  std::size_t stride = 1;    ///< Numbers from pixel to pixel.
  std::size_t count = 0, channels = 0;
  const float* weight = nullptr;  ///< 9 rows of `channels`; this, `bias` and `out` are 64-byte aligned.
  const float* bias = nullptr;
  float* out = nullptr;
};

/// The larger of 0 and W x + b, summed in the same order for every pixel.
void convolve_line(const PictureLine& line);

}  // namespace mien::model
