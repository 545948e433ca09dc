#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "mien/core/error.h"

namespace mien::render {

/// 8-bit sRGB, red first; 0 to 255.
using Rgb = std::array<std::uint8_t, 3>;

/// A picture, sRGB, rows from the top.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;  ///< Shape: height x width x 3.

  Image() = default;
  Image(int width_px, int height_px, Rgb fill = {0, 0, 0});

  /// The three bytes of one pixel; x and y inside the picture.
  [[nodiscard]] std::uint8_t* pixel(int x, int y) { return rgb.data() + 3 * (std::size_t(y) * width + x); }
  [[nodiscard]] const std::uint8_t* pixel(int x, int y) const {
    return rgb.data() + 3 * (std::size_t(y) * width + x);
  }
  bool operator==(const Image&) const = default;
};

/// Copies `part` into `picture` with its top left corner at (x, y); what falls outside is left out.
void paste(Image& picture, const Image& part, int x, int y);

/// What a pixel of a PNG file is, 8 bits each, sRGB; alpha is linear and not multiplied in.
enum class PngPixels : std::uint8_t { rgb, rgba };

/// Rows from the top as a PNG file's content. Errors: out_of_range (no pixels, larger than 16384 a side, or
/// another number of bytes than the size says).
[[nodiscard]] Result<std::vector<std::byte>> encode_png(int width, int height, PngPixels kind,
                                                        std::span<const std::uint8_t> bytes);

/// The picture as a PNG file's content. Errors: out_of_range (a picture without pixels, or larger than 16384
/// a side).
[[nodiscard]] Result<std::vector<std::byte>> encode_png(const Image& picture);
/// The same into a file, whole or not at all. Errors: those of encode_png and of write_file.
[[nodiscard]] Result<void> write_png(const std::filesystem::path& path, const Image& picture);

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
