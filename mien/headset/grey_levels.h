#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace mien::headset {

/// How often each of the levels 0 to 255 was met. What it gives is a share of 255, 0 to 1, and 0 of none.
class GreyLevels {
 public:
  /// Neighbours are mostly of one level, and a count must be written before it is read again: so those in
  /// turn are counted in tables of their own.
  void add(std::span<const std::uint8_t> levels) {
    std::array<std::array<std::uint32_t, 256>, 4> tables{};
    std::size_t i = 0;
    for (; i + tables.size() <= levels.size(); i += tables.size())
      for (std::size_t table = 0; table < tables.size(); ++table) ++tables[table][levels[i + table]];
    for (; i < levels.size(); ++i) ++tables[0][levels[i]];
    for (std::size_t level = 0; level < times_.size(); ++level)
      for (const auto& table : tables) times_[level] += table[level];
    count_ += levels.size();
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
