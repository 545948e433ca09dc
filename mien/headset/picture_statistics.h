#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "mien/headset/grey_picture.h"
#include "mien/sensor/sample.h"

namespace mien::headset {

/// How a picture was taken: exposure, sharpness, contrast, and what tells it from the one before. All numbers
/// are of its grey levels as they are, 0 to 255 as 0 to 1.
struct PictureStatistics {
  float mean = 0;       ///< 0 to 1.
  float saturated = 0;  ///< Share of pixels of kSaturatedLevel or more, 0 to 1.
  float black = 0;      ///< Share of pixels of kBlackLevel or less, 0 to 1.
  /// The variance of the Laplacian (four neighbours less four times the pixel, without the picture's edge)
  /// over 20 times the variance of the same pixels: 1 for white noise, less the smoother, 3.2 for a
  /// chessboard of single pixels, 0 without contrast. It does not depend on exposure; where there is hardly
  /// any contrast (p98 - p2) it is the noise's. Of pictures of one size and scene alone it compares the lens.
  float sharpness = 0;
  float p2 = 0;   ///< The least level that 2 % of the pixels do not exceed, 0 to 1.
  float p98 = 0;  ///< The same of 98 %.
  /// Of size and pixels: two pictures of one hash are the same, but for one chance in 2^64.
  std::uint64_t hash = 0;
  bool operator==(const PictureStatistics&) const = default;
};

inline constexpr int kSaturatedLevel = 250;
inline constexpr int kBlackLevel = 5;

/// Of a picture of at most kMaxPictureWidth x kMaxPictureHeight; all 0 of one without pixels. Sums are whole
/// numbers: the same bits always. No allocation. Thread-safe.
[[nodiscard]] PictureStatistics statistics_of(const GreyPicture& picture);

/// What is measured is the picture as PictureDecoder gives it for so many pixels either way, whoever measures
/// it and whatever else is made of it.
inline constexpr int kMeasuredSide = 96;

/// Tells a camera whose picture stands still: sensors have noise, so no two pictures are the same.
class FrozenPictures {
 public:
  /// So many of one content in a row.
  static constexpr int kFrozen = 3;

  /// The next picture's PictureStatistics::hash. True: it is frozen.
  bool add(std::uint64_t hash);
  /// Another connection: what it sends is compared with nothing that was before.
  void restart() { in_a_row_ = 0; }

 private:
  std::uint64_t hash_ = 0;
  int in_a_row_ = 0;
};

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
