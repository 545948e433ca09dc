#include "mien/core/sliding_median.h"

#include <gtest/gtest.h>

#include <vector>

#include "mien/core/random.h"

namespace mien::sliding_median_test {
namespace {

double median_of(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

template <std::size_t N>
void agrees_with_sorting() {
  Random random(N);
  SlidingMedian<N> median;
  std::vector<double> all;
  for (int i = 0; i < 3000; ++i) {
    // Few different values, so that many are alike; 0 and -0 among them.
    const double value = (i % 7 == 0 ? -1.0 : 1.0) * static_cast<double>(random.below(6));
    all.push_back(value);
    const std::size_t from = all.size() - std::min(all.size(), N);
    ASSERT_EQ(median.add(value), median_of({all.begin() + static_cast<std::ptrdiff_t>(from), all.end()}));
    ASSERT_EQ(median.count(), all.size() - from);
  }
}

TEST(SlidingMedian, AgreesWithSorting) {
  agrees_with_sorting<1>();
  agrees_with_sorting<2>();
  agrees_with_sorting<5>();
  agrees_with_sorting<10>();
}

TEST(SlidingMedian, BeginsAnew) {
  SlidingMedian<10> median;
  EXPECT_EQ(median.median(), 0);
  median.add(5);
  median.add(7);
  EXPECT_EQ(median.median(), 6);
  median.reset();
  EXPECT_EQ(median.count(), 0u);
  EXPECT_EQ(median.median(), 0);
  EXPECT_EQ(median.add(-3), -3);
}

}  // namespace
}  // namespace mien::sliding_median_test
