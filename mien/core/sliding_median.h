#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace mien {

/// The median of the newest N values: what stands apart in fewer than half of them does not show. Of an even
/// number of values it is the mean of the middle two. It answers late by (N - 1) / 2 values. Values must be
/// finite. No allocation; O(N) a value.
template <std::size_t N>
class SlidingMedian {
  static_assert(N > 0);

 public:
  /// Takes a value; returns the median of it and those before it, as many as there are, N at the most.
  double add(double value) {
    auto end = sorted_.begin() + static_cast<std::ptrdiff_t>(count_);
    if (count_ == N) {
      const auto oldest = std::lower_bound(sorted_.begin(), end, values_[next_]);
      std::move(oldest + 1, end, oldest);
      --end;
    } else {
      ++count_;
    }
    const auto place = std::upper_bound(sorted_.begin(), end, value);
    std::move_backward(place, end, end + 1);
    *place = value;
    values_[next_] = value;
    next_ = (next_ + 1) % N;
    return median();
  }
  /// 0 before the first value.
  [[nodiscard]] double median() const {
    if (count_ == 0) return 0;
    return 0.5 * (sorted_[(count_ - 1) / 2] + sorted_[count_ / 2]);
  }
  /// How many values there are, at most N.
  [[nodiscard]] std::size_t count() const { return count_; }
  void reset() {
    count_ = 0;
    next_ = 0;
  }

 private:
  std::array<double, N> values_{};  // In the order in which they came, from next_ on once full.
  std::array<double, N> sorted_{};
  std::size_t count_ = 0;
  std::size_t next_ = 0;
};

}  // namespace mien
