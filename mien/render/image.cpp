#include "mien/render/image.h"

#include <fmt/format.h>
#include <png.h>
#include <turbojpeg.h>

#include <algorithm>
#include <memory>

#include "mien/core/files.h"

namespace mien::render {
namespace {

constexpr int kMaxSide = 16384;

/// Whether a file can hold so many numbers as a picture of this size, so many a pixel.
bool fits(int width, int height, std::size_t channels, std::span<const std::uint8_t> numbers) {
  return width >= 1 && height >= 1 && width <= kMaxSide && height <= kMaxSide &&
         numbers.size() == channels * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

}  // namespace

Image::Image(int width_px, int height_px, Rgb fill)
    : width(width_px), height(height_px), rgb(std::size_t(3) * width_px * height_px) {
  if (fill == Rgb{0, 0, 0}) return;
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = fill[i % 3];
}

void paste(Image& picture, const Image& part, int x, int y) {
  const int left = std::max(0, -x);
  const int right = std::min(part.width, picture.width - x);
  if (left >= right) return;
  for (int row = std::max(0, -y); row < std::min(part.height, picture.height - y); ++row)
    std::copy(part.pixel(left, row), part.pixel(left, row) + std::ptrdiff_t(3) * (right - left),
              picture.pixel(x + left, y + row));
}

Result<std::vector<std::byte>> encode_png(int width, int height, PngPixels kind,
                                          std::span<const std::uint8_t> bytes) {
  if (!fits(width, height, kind == PngPixels::rgba ? 4 : 3, bytes))
    return fail(ErrorCode::out_of_range, fmt::format("a picture of {} x {} cannot be written", width, height),
                "PNG", fmt::format("sides are 1 to {} pixels", kMaxSide));
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(width);
  header.height = static_cast<png_uint_32>(height);
  header.format = kind == PngPixels::rgba ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  // The simplified writer may not say its size beforehand without doing the work; its bound is cheap.
  std::vector<std::byte> content(PNG_IMAGE_PNG_SIZE_MAX(header));
  png_alloc_size_t size = content.size();
  if (png_image_write_to_memory(&header, content.data(), &size, 0, bytes.data(), 0, nullptr) == 0)
    return fail(ErrorCode::internal, fmt::format("libpng: {}", header.message), "PNG");
  content.resize(size);
  return content;
}

Result<std::vector<std::byte>> encode_png(const Image& picture) {
  return encode_png(picture.width, picture.height, PngPixels::rgb, picture.rgb);
}

Result<void> write_png(const std::filesystem::path& path, const Image& picture) {
  MIEN_TRY_ASSIGN(const auto content, encode_png(picture));
  return write_file(path, content);
}

Result<std::vector<std::byte>> encode_jpeg(int width, int height, JpegPixels pixels, int quality,
                                           std::span<const std::uint8_t> numbers) {
  const bool grey = pixels == JpegPixels::grey;
  if (!fits(width, height, grey ? 1 : 3, numbers) || quality < 1 || quality > 100)
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
