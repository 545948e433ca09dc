#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "mien/headset/jpeg_gate.h"
#include "mien/headset/picture_decoder.h"

namespace {

using mien::headset::PictureDecoder;

/// A picture's pixels, or none.
std::vector<std::uint8_t> decoded(PictureDecoder& decoder, std::span<const std::byte> jpeg, int least) {
  const auto grey = decoder.decode(jpeg, least, least);
  if (!grey) return {};
  const auto header = mien::headset::check_jpeg(jpeg);
  if (!header || grey->width < 1 || grey->height < 1 || grey->width > header->width ||
      grey->height > header->height)
    std::abort();
  if (grey->pixels.size() != static_cast<std::size_t>(grey->width) * static_cast<std::size_t>(grey->height))
    std::abort();
  return {grey->pixels.begin(), grey->pixels.end()};
}

}  // namespace

// What the gate lets through has the size that it says; the same picture gives the same pixels in a decoder
// that had others before.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static PictureDecoder used = PictureDecoder::create().value();
  const auto bytes = std::as_bytes(std::span(data, size));
  const auto header = mien::headset::check_jpeg(bytes);
  if (!header) {
    if (used.decode(bytes, 1, 1)) std::abort();
    return 0;
  }
  if (header->width < 1 || header->height < 1 || header->bytes > size) std::abort();
  if (header->width > mien::headset::kMaxPictureWidth || header->height > mien::headset::kMaxPictureHeight)
    std::abort();
  PictureDecoder fresh = PictureDecoder::create().value();
  const int least = size > 0 ? data[size / 2] : 0;
  if (decoded(used, bytes, least) != decoded(fresh, bytes, least)) std::abort();
  return 0;
}
