#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>
#include <string_view>

namespace mien::headset {

/// Why a picture of a camera is not decoded.
enum class PictureFault : std::uint8_t {
  not_a_jpeg,     ///< Something stands where a JPEG has something else.
  truncated,      ///< It ends before its end.
  overlong,       ///< Over sensor::kMaxPayload.
  too_large,      ///< Over kMaxPictureWidth x kMaxPictureHeight.
  no_size,        ///< Its frame header is missing, or says 0.
  repeated_size,  ///< It has more than one.
  progressive,
  lossless,
  arithmetic,  ///< Arithmetic coding.
  hierarchical,
  bits,        ///< Other than 8 a sample.
  components,  ///< Other than 1 or 3: CMYK.
  sampling,    ///< Of its components, beyond 1 to 4.
  scans,       ///< More than one, or one without all components.
  tables,      ///< It does not bring all tables that it needs: another picture's would be taken.
  damaged,     ///< Its coded data do not decode.
};
inline constexpr std::size_t kPictureFaults = static_cast<std::size_t>(PictureFault::damaged) + 1;

/// "progressive", "too large": for people.
[[nodiscard]] std::string_view name_of(PictureFault fault);

inline constexpr int kMaxPictureWidth = 1280;
inline constexpr int kMaxPictureHeight = 960;

/// What a JPEG that may be decoded says of itself.
struct JpegHeader {
  int width = 0;       ///< 1 to kMaxPictureWidth.
  int height = 0;      ///< 1 to kMaxPictureHeight.
  int components = 0;  ///< 1, grey, or 3.
  /// Up to its end; what stands behind that is no part of it.
  std::size_t bytes = 0;
  bool operator==(const JpegHeader&) const = default;
};

/// Walks through a picture's markers before libjpeg sees any of it, and lets through only what cameras send:
/// sequential Huffman coding of 8 bits, one scan, all tables in the picture, so that none depends on the one
/// before. Its cost is bounded by its bytes, of which 10,000 scans are no more than one. Says nothing of the
/// coded data. No allocation. Thread-safe.
[[nodiscard]] std::expected<JpegHeader, PictureFault> check_jpeg(std::span<const std::byte> picture);

}  // namespace mien::headset
