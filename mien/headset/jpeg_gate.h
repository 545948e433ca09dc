#pragma once

#include <cstddef>
#include <expected>
#include <span>

#include "mien/headset/picture_fault.h"

namespace mien::headset {

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
