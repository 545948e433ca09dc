#include "mien/model/kernels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/core/random.h"
#include "mien/model/architecture.h"

namespace mien::model {
namespace {

std::vector<float> numbers(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<float> values(count);
  for (float& v : values) v = static_cast<float>(random.uniform(-1, 1));
  return values;
}

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

TEST_P(Kernels, LinearLayers) {
  for (const std::size_t rows : {1U, 2U, 3U, 7U, 8U, 9U, 23U, 121U})
    for (const auto& [out, in] : {std::pair<std::size_t, std::size_t>{53, 40}, {64, 33}, {96, 130}}) {
      const auto weight = numbers(out * in, 1), bias = numbers(out, 2), x = numbers(rows * in, 3);
      const std::size_t stride = padded(out);
      const auto add = aligned(numbers(rows * stride, 4));
      AlignedFloats y(rows * stride);
      const PackedLinear layer = pack_linear(weight, bias, out, in, 0, in);
      apply_linear(layer, rows, x.data(), in, add.data(), stride, Activation::relu, y.data(), stride);
      for (std::size_t r = 0; r < rows; ++r)
        for (std::size_t o = 0; o < out; ++o) {
          double sum = double{bias[o]} + double{add[r * stride + o]};
          for (std::size_t i = 0; i < in; ++i) sum += double{weight[o * in + i]} * double{x[r * in + i]};
          ASSERT_NEAR(y[r * stride + o], std::max(sum, 0.0), 1e-5)
              << rows << " " << out << " " << r << " " << o;
        }
    }
}

TEST_P(Kernels, LinearLayersOfSomeColumns) {
  const std::size_t out = 40, total = 50, first = 11, count = 20;
  const auto weight = numbers(out * total, 1), x = numbers(count, 3);
  AlignedFloats y(padded(out));
  apply_linear(pack_linear(weight, {}, out, total, first, count), 1, x.data(), count, nullptr, 0,
               Activation::none, y.data(), padded(out));
  for (std::size_t o = 0; o < out; ++o) {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += double{weight[o * total + first + i]} * double{x[i]};
    EXPECT_NEAR(y[o], sum, 1e-5);
  }
  for (std::size_t o = out; o < padded(out); ++o) EXPECT_EQ(y[o], 0);
}

TEST_P(Kernels, Products) {
  const std::size_t rows = 13, depth = 45, columns = 64;
  const auto a = aligned(numbers(rows * depth, 5)), b = aligned(numbers(depth * columns, 6));
  AlignedFloats c(rows * columns);
  multiply(rows, depth, columns, a.data(), depth, b.data(), columns, c.data(), columns);
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t j = 0; j < columns; ++j) {
      double sum = 0;
      for (std::size_t k = 0; k < depth; ++k) sum += double{a[r * depth + k]} * double{b[k * columns + j]};
      ASSERT_NEAR(c[r * columns + j], sum, 1e-5);
    }
}

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

TEST(KernelTiles, TheWidthOfTheTileDoesNotChangeTheResult) {
  // A row computed among eight equals the row computed alone, to the bit: short windows and long ones agree.
  const std::size_t rows = 9, in = 70, out = 64;
  const auto weight = numbers(out * in, 1), x = numbers(rows * in, 3);
  const PackedLinear layer = pack_linear(weight, {}, out, in, 0, in);
  AlignedFloats together(rows * out), alone(out);
  apply_linear(layer, rows, x.data(), in, nullptr, 0, Activation::none, together.data(), out);
  for (std::size_t r = 0; r < rows; ++r) {
    apply_linear(layer, 1, x.data() + r * in, in, nullptr, 0, Activation::none, alone.data(), out);
    for (std::size_t o = 0; o < out; ++o) ASSERT_EQ(alone[o], together[r * out + o]);
  }
}

}  // namespace
}  // namespace mien::model
