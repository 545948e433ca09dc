#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace mien::headset {

/// How often each of the levels 0 to 255 was met. What it gives is a share of 255, 0 to 1, and 0 of none.
class GreyLevels {
 public:
  void add(std::uint8_t level) {
    ++times_[level];
    ++count_;
  }
  [[nodiscard]] float mean() const {
    std::uint64_t sum = 0;
    for (std::size_t level = 0; level < times_.size(); ++level) sum += level * times_[level];
    return over(static_cast<double>(sum), 255.0 * static_cast<double>(count_));
  }
  /// Of those from one level to another, both within.
  [[nodiscard]] float share(std::size_t from, std::size_t to) const {
    std::uint64_t sum = 0;
    for (std::size_t level = from; level <= to; ++level) sum += times_[level];
    return over(static_cast<double>(sum), static_cast<double>(count_));
  }
  /// The least level that so many per cent do not exceed.
  [[nodiscard]] float percentile(std::uint64_t per_cent) const {
    std::uint64_t below = 0;
    std::size_t level = 0;
    for (; level + 1 < times_.size(); ++level)
      if ((below += times_[level]) * 100 >= count_ * per_cent) break;
    return count_ == 0 ? 0.0F : static_cast<float>(level) / 255;
  }

 private:
  [[nodiscard]] static float over(double sum, double whole) {
    return whole == 0 ? 0.0F : static_cast<float>(sum / whole);
  }
  std::array<std::uint32_t, 256> times_{};
  std::uint64_t count_ = 0;
};

}  // namespace mien::headset
