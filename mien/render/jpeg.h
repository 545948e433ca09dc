#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/error.h"

namespace mien::render {

/// What the numbers of a JPEG's pixels are, and how many there are.
enum class JpegPixels : std::uint8_t {
  colour,  ///< sRGB for eyes, which see fine differences of colour less: halved sideways and downward.
  data,    ///< Three numbers a pixel, such as a normal: all at full size.
  grey,    ///< One number a pixel.
};

/// Pixels, 8 bits a number (RGB, but of `grey`), rows from the top, as a JPEG file's content (libjpeg-turbo).
/// `quality`: 1 to 100, higher is finer and larger. The same input and library give the same bytes. Errors:
/// out_of_range (no pixels, larger than 16384 a side, another number of bytes than the size says, or
/// quality).
[[nodiscard]] Result<std::vector<std::byte>> encode_jpeg(int width, int height, JpegPixels pixels,
                                                         int quality, std::span<const std::uint8_t> numbers);

}  // namespace mien::render
