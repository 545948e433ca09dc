#include "mien/headset/picture_statistics.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "mien/headset/grey_levels.h"

namespace mien::headset {
namespace {

constexpr double kWhiteNoise = 20;  // 4 * 4 + 4 * 1: what the Laplacian makes of a variance of 1.

struct Moments {
  std::int64_t sum = 0;
  std::int64_t squares = 0;
  /// Times the square of how many there are: a whole number. 1.2 million values of at most 1020 stay below
  /// 2^61.
  [[nodiscard]] std::int64_t variance(std::int64_t count) const { return count * squares - sum * sum; }
};

float sharpness_of(const GreyPicture& picture) {
  const auto width = static_cast<std::size_t>(picture.width);
  Moments laplacian;
  Moments levels;
  for (int y = 1; y + 1 < picture.height; ++y) {
    const std::uint8_t* const row = picture.pixels.data() + static_cast<std::size_t>(y) * width;
    const std::uint8_t* const above = row - width;
    const std::uint8_t* const below = row + width;
    // 32 bits hold a row's, and the compiler makes vectors of them: 1280 squares of at most 1020 are 1.3e9.
    std::int32_t sum = 0;
    std::int32_t squares = 0;
    std::int32_t laplacian_sum = 0;
    std::int32_t laplacian_squares = 0;
    for (std::size_t x = 1; x + 1 < width; ++x) {
      const std::int32_t level = row[x];
      const std::int32_t difference = row[x - 1] + row[x + 1] + above[x] + below[x] - 4 * level;
      sum += level;
      squares += level * level;
      laplacian_sum += difference;
      laplacian_squares += difference * difference;
    }
    levels.sum += sum;
    levels.squares += squares;
    laplacian.sum += laplacian_sum;
    laplacian.squares += laplacian_squares;
  }
  const auto count =
      static_cast<std::int64_t>(std::max(picture.width - 2, 0)) * std::max(picture.height - 2, 0);
  const std::int64_t variance = levels.variance(count);
  if (variance == 0) return 0;
  return static_cast<float>(static_cast<double>(laplacian.variance(count)) /
                            (kWhiteNoise * static_cast<double>(variance)));
}

/// Eight bytes at a time, each mixed into all bits by a multiplication and a shift (the finaliser of
/// splitmix64, whose constants these are).
std::uint64_t hash_of(const GreyPicture& picture) {
  std::uint64_t hash = 0;
  const auto mix = [&hash](std::uint64_t word) {
    hash = (hash ^ word) * 0xBF58476D1CE4E5B9U;
    hash = (hash ^ hash >> 27U) * 0x94D049BB133111EBU;
    hash ^= hash >> 31U;
  };
  mix(static_cast<std::uint64_t>(picture.width) << 32U | static_cast<std::uint64_t>(picture.height) |
      1U << 31U);
  for (std::span<const std::uint8_t> left = picture.pixels; !left.empty();) {
    std::uint64_t word = 0;
    const std::size_t size = std::min(left.size(), sizeof(word));
    std::memcpy(&word, left.data(), size);
    if constexpr (std::endian::native != std::endian::little) word = __builtin_bswap64(word);
    mix(word);
    left = left.subspan(size);
  }
  return hash;
}

}  // namespace

PictureStatistics statistics_of(const GreyPicture& picture) {
  PictureStatistics statistics;
  if (picture.pixels.empty()) return statistics;
  GreyLevels levels;
  levels.add(picture.pixels);
  statistics.mean = levels.mean();
  statistics.saturated = levels.share(kSaturatedLevel, 255);
  statistics.black = levels.share(0, kBlackLevel);
  statistics.sharpness = sharpness_of(picture);
  statistics.p2 = levels.percentile(2);
  statistics.p98 = levels.percentile(98);
  statistics.hash = hash_of(picture);
  return statistics;
}

bool FrozenPictures::add(std::uint64_t hash) {
  in_a_row_ = in_a_row_ > 0 && hash == hash_ ? std::min(in_a_row_ + 1, kFrozen) : 1;
  hash_ = hash;
  return in_a_row_ >= kFrozen;
}

}  // namespace mien::headset
