#include "mien/model/kernels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/core/random.h"
#include "mien/model/aligned.h"
#include "mien/model/architecture.h"
#include "tests/model/numbers.h"

namespace mien::model::kernels_test {
namespace {

AlignedFloats aligned(const std::vector<float>& values) {
  AlignedFloats copy(values.size());
  std::copy(values.begin(), values.end(), copy.data());
  return copy;
}

/// Every variant that this machine can run, against plain loops in double precision.
class Kernels : public testing::TestWithParam<std::string_view> {
 protected:
  void SetUp() override {
    force_kernel(GetParam());
    ASSERT_EQ(kernel_name(), GetParam());
  }
  void TearDown() override { force_kernel(""); }
};

TEST_P(Kernels, Softmax) {
  for (const std::size_t columns : {1U, 31U, 32U, 33U, 121U}) {
    const std::size_t rows = 3, stride = padded(columns);
    auto x = aligned(numbers(rows * stride, 7));
    for (std::size_t i = 0; i < rows * stride; ++i) x[i] *= 200;  // Far apart: most shares vanish.
    const auto before = std::vector<float>(x.data(), x.data() + x.size());
    softmax_rows(rows, columns, 0.125F, x.data(), stride);
    for (std::size_t r = 0; r < rows; ++r) {
      double high = -1e9, sum = 0;
      for (std::size_t i = 0; i < columns; ++i) high = std::max(high, 0.125 * double{before[r * stride + i]});
      for (std::size_t i = 0; i < columns; ++i)
        sum += std::exp(0.125 * double{before[r * stride + i]} - high);
      for (std::size_t i = 0; i < columns; ++i)
        ASSERT_NEAR(x[r * stride + i], std::exp(0.125 * double{before[r * stride + i]} - high) / sum, 1e-6);
      for (std::size_t i = columns; i < stride; ++i) ASSERT_EQ(x[r * stride + i], 0);
    }
  }
}

TEST_P(Kernels, LayerNormalisation) {
  const std::size_t rows = 5, columns = 96;
  auto x = aligned(numbers(rows * columns, 8));
  for (std::size_t i = 0; i < columns; ++i) x[i] = 1000 + x[i];  // A far mean must not eat the digits.
  const auto gain = aligned(numbers(columns, 9)), shift = aligned(numbers(columns, 10));
  const auto before = std::vector<float>(x.data(), x.data() + x.size());
  normalise_rows(rows, columns, gain.data(), shift.data(), x.data(), columns);
  for (std::size_t r = 0; r < rows; ++r) {
    double mean = 0, variance = 0;
    for (std::size_t i = 0; i < columns; ++i) mean += double{before[r * columns + i]} / columns;
    for (std::size_t i = 0; i < columns; ++i)
      variance += std::pow(double{before[r * columns + i]} - mean, 2) / columns;
    for (std::size_t i = 0; i < columns; ++i)
      ASSERT_NEAR(x[r * columns + i],
                  (double{before[r * columns + i]} - mean) / std::sqrt(variance + kLayerNormEpsilon) *
                          double{gain[i]} +
                      double{shift[i]},
                  r == 0 ? 2e-3 : 1e-5);
  }
}

TEST_P(Kernels, Gates) {
  const std::size_t width = 96;
  auto from_input = numbers(3 * width, 11), from_state = numbers(3 * width, 12);
  for (std::size_t i = 0; i < width; i += 7) from_input[i] *= 300;              // Gates that are quite open
  for (std::size_t i = width; i < 2 * width; i += 5) from_state[i] *= 300;      // or quite shut,
  for (std::size_t i = 2 * width; i < 3 * width; i += 3) from_input[i] *= 300;  // and tanh at its ends.
  const auto before = numbers(width, 13);
  auto state = aligned(before);
  apply_gates(width, aligned(from_input).data(), aligned(from_state).data(), state.data());
  const auto sigmoid = [](double x) { return 1 / (1 + std::exp(-x)); };
  for (std::size_t i = 0; i < width; ++i) {
    const auto input = [&](std::size_t part) { return double{from_input[part * width + i]}; };
    const auto carried = [&](std::size_t part) { return double{from_state[part * width + i]}; };
    const double r = sigmoid(input(0) + carried(0)), z = sigmoid(input(1) + carried(1));
    const double n = std::tanh(input(2) + r * carried(2));
    ASSERT_NEAR(state[i], (1 - z) * n + z * double{before[i]}, 1e-6) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Kernels, testing::ValuesIn(available_kernels()),
                         [](const auto& variant) { return std::string(variant.param); });

}  // namespace
}  // namespace mien::model::kernels_test
