#include "mien/render/jpeg.h"

#include <fmt/format.h>
#include <turbojpeg.h>

#include <memory>

namespace mien::render {

Result<std::vector<std::byte>> encode_jpeg(int width, int height, JpegPixels pixels, int quality,
                                           std::span<const std::uint8_t> numbers) {
  const bool grey = pixels == JpegPixels::grey;
  constexpr int kMaxSide = 16384;
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide || quality < 1 || quality > 100 ||
      numbers.size() != (grey ? 1 : 3) * static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
    return fail(ErrorCode::out_of_range,
                fmt::format("a picture of {} x {} and quality {} cannot be written", width, height, quality),
                "JPEG", fmt::format("sides are 1 to {} pixels, quality is 1 to 100", kMaxSide));
  struct Close {
    void operator()(void* handle) const { tjDestroy(handle); }
    void operator()(unsigned char* content) const { tjFree(content); }
  };
  const std::unique_ptr<void, Close> encoder(tjInitCompress());
  unsigned char* written = nullptr;
  unsigned long size = 0;
  const int subsampling = grey ? TJSAMP_GRAY : pixels == JpegPixels::colour ? TJSAMP_420 : TJSAMP_444;
  const int status = tjCompress2(encoder.get(), numbers.data(), width, 0, height, grey ? TJPF_GRAY : TJPF_RGB,
                                 &written, &size, subsampling, quality, TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, Close> content(written);
  if (status != 0)
    return fail(ErrorCode::internal, fmt::format("libjpeg-turbo: {}", tjGetErrorStr2(encoder.get())), "JPEG");
  const auto bytes = std::as_bytes(std::span(content.get(), size));
  return std::vector<std::byte>(bytes.begin(), bytes.end());
}

}  // namespace mien::render
