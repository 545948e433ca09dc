#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "mien/headset/picture_statistics.h"
#include "mien/sensor/sample.h"

namespace mien::headset {

/// The values of a sample of SampleKind::picture, in their order.
enum class PictureValue : std::uint8_t {
  mean,       ///< PictureStatistics::mean, and so on.
  saturated,  ///< Share of pixels.
  black,      ///< Share of pixels.
  sharpness,
  p2,
  p98,
  kbytes,  ///< Length of the picture as its camera sent it, 10^3 bytes.
};
inline constexpr std::size_t kPictureValues = static_cast<std::size_t>(PictureValue::kbytes) + 1;

/// Sensor, sequence and time are the caller's. `jpeg_bytes`: length of the picture.
[[nodiscard]] inline sensor::Sample sample_of(const PictureStatistics& statistics, std::size_t jpeg_bytes) {
  sensor::Sample sample;
  sample.kind = sensor::SampleKind::picture;
  sample.count = kPictureValues;
  const std::array<float, kPictureValues> values = {statistics.mean,
                                                    statistics.saturated,
                                                    statistics.black,
                                                    statistics.sharpness,
                                                    statistics.p2,
                                                    statistics.p98,
                                                    static_cast<float>(jpeg_bytes) / 1000};
  for (std::size_t i = 0; i < values.size(); ++i) sample.values[i] = values[i];
  return sample;
}

}  // namespace mien::headset
