#include <cstdint>
#include <cstdlib>
#include <span>

#include "mien/headset/picture_file.h"

// What is read has as many pixels as it says; it is read again to the same, and scaled without a fault.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  const auto picture = mien::headset::parse_picture(bytes, "fuzz");
  if (!picture) return 0;
  if (picture->width < 1 || picture->height < 1 ||
      picture->pixels.size() !=
          static_cast<std::size_t>(picture->width) * static_cast<std::size_t>(picture->height))
    std::abort();
  const auto again = mien::headset::parse_picture(bytes, "fuzz");
  if (!again || !(*again == *picture)) std::abort();
  if (mien::headset::scaled_picture(picture->view(), 7, 5).pixels.size() != 35) std::abort();
  return 0;
}
