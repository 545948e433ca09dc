#include "mien/headset/etvr_frames.h"

#include <array>

namespace mien::headset {
namespace {

// FF A0 FF A1, two bytes of length, FF D8.
constexpr std::uint64_t kFrame = 0xFFA0'FFA1'0000'FFD8;
constexpr std::uint64_t kFrameBits = 0xFFFF'FFFF'0000'FFFF;
constexpr std::array kPictureFirst = {std::byte{0xFF}, std::byte{0xD8}};

std::size_t length_in(std::uint64_t frame) {
  return (frame >> 24U & 0xFFU) | (frame >> 16U & 0xFFU) << 8U;
}

}  // namespace

std::optional<std::span<const std::byte>> EtvrFrames::read(std::span<const std::byte>& bytes) {
  while (const auto newest = pictures_.next(bytes)) {
    if ((*newest & kFrameBits) == kFrame)
      pictures_.begin(kPictureFirst, length_in(*newest));
    else if (pictures_.is_open() && pictures_.add(static_cast<std::byte>(*newest)))
      return pictures_.picture();
  }
  return std::nullopt;
}

}  // namespace mien::headset
