#pragma once

#include <cstddef>
#include <cstdint>
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

}  // namespace mien::headset
