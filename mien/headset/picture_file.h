#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/headset/grey_picture.h"

namespace mien::headset {

/// A picture in grey that owns its pixels.
struct PictureCopy {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;  ///< Row by row from the top, height x width of them.

  [[nodiscard]] GreyPicture view() const { return {width, height, pixels}; }
  bool operator==(const PictureCopy&) const = default;
};

/// Longest side of a picture that is read from a file, pixels, and the most of them.
inline constexpr int kMaxFileSide = 8192;
inline constexpr std::size_t kMaxFilePixels = std::size_t{1} << 26U;

/// Reads a picture that somebody else recorded, in grey: JPEG of any kind that libjpeg-turbo decodes, or
/// Netpbm's PGM and PPM (P2, P3, P5, P6; 8 or 16 bits, the upper ones of which are kept). Colours become
/// their luma (ITU-R BT.601). `where` names the source in messages. Errors: malformed, truncated, unsupported
/// (another format), out_of_range (kMaxFileSide, kMaxFilePixels). Allocates by what the bytes hold, or for a
/// JPEG by its size within these limits. Thread-safe.
[[nodiscard]] Result<PictureCopy> parse_picture(std::span<const std::byte> bytes, const std::string& where);

/// The picture at another size, sides from 1 on: each pixel the mean of what it covers, by area.
[[nodiscard]] PictureCopy scaled_picture(const GreyPicture& picture, int width, int height);

}  // namespace mien::headset
