#include "mien/headset/picture_decoder.h"

#include <turbojpeg.h>

namespace mien::headset {
namespace {

constexpr int kWhole = 8;
constexpr std::size_t kMostPixels = static_cast<std::size_t>(kMaxPictureWidth) * kMaxPictureHeight;

int scaled(int side, int eighths) {
  return (side * eighths + kWhole - 1) / kWhole;
}

}  // namespace

void PictureDecoder::Close::operator()(void* decoder) const {
  tjDestroy(decoder);
}

PictureDecoder::PictureDecoder(void* decoder)
    : decoder_(decoder), pixels_(std::make_unique_for_overwrite<std::uint8_t[]>(kMostPixels)) {}

Result<PictureDecoder> PictureDecoder::create() {
  void* const decoder = tjInitDecompress();
  if (decoder == nullptr) return fail(ErrorCode::internal, "libjpeg-turbo gives no decoder", "cameras");
  return PictureDecoder(decoder);
}

std::expected<GreyPicture, PictureFault> PictureDecoder::decode(std::span<const std::byte> jpeg,
                                                                int least_width, int least_height) {
  const auto header = check_jpeg(jpeg);
  if (!header) return std::unexpected(header.error());
  // Of libjpeg's eighths these are the quick ones: of a picture of 240 x 240, 48, 61, 68 and 120 us, where 5,
  // 6 and 7 eighths take 112, 168 and 233.
  int eighths = 1;
  while (eighths < kWhole &&
         (scaled(header->width, eighths) < least_width || scaled(header->height, eighths) < least_height))
    eighths *= 2;
  const GreyPicture made{
      .width = scaled(header->width, eighths),
      .height = scaled(header->height, eighths),
      .pixels = std::span(pixels_.get(), static_cast<std::size_t>(scaled(header->width, eighths)) *
                                             static_cast<std::size_t>(scaled(header->height, eighths)))};
  // It takes the scale that fits into this size, which is the one above. Its warnings are of broken data.
  const int status = tjDecompress2(decoder_.get(), reinterpret_cast<const unsigned char*>(jpeg.data()),
                                   header->bytes, pixels_.get(), made.width, 0, made.height, TJPF_GRAY,
                                   TJFLAG_STOPONWARNING | TJFLAG_ACCURATEDCT);
  if (status != 0) return std::unexpected(PictureFault::damaged);
  return made;
}

}  // namespace mien::headset
