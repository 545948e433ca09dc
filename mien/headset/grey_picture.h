#pragma once

#include <cstdint>
#include <span>

namespace mien::headset {

/// A picture in grey, which somebody else owns.
struct GreyPicture {
  int width = 0;
  int height = 0;
  std::span<const std::uint8_t> pixels;  ///< Row by row from the top, height x width of them.
};

}  // namespace mien::headset
