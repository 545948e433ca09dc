#include "mien/model/linear.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <vector>

#include "mien/core/random.h"
#include "tests/model/numbers.h"

namespace mien::model::linear_test {
namespace {

/// Rounded to bf16, halves to even, by way of what lies around it.
double as_bf16(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x) & 0xffff0000U;
  const double below = double{std::bit_cast<float>(bits)},
               above = double{std::bit_cast<float>(bits + 0x10000U)};
  const double from_below = std::abs(double{x} - below), from_above = std::abs(above - double{x});
  if (from_below == from_above) return (bits & 0x10000U) == 0 ? below : above;
  return from_below < from_above ? below : above;
}

/// What `count` numbers become in a precision: int8 by the largest among them.
std::vector<double> as(Precision precision, const float* values, std::size_t count) {
  std::vector<double> out(values, values + count);
  float largest = 0;
  for (const double v : out) largest = std::max(largest, static_cast<float>(std::abs(v)));
  for (std::size_t i = 0; i < count; ++i) {
    if (precision == Precision::bf16) out[i] = as_bf16(values[i]);
    if (precision == Precision::int8)
      out[i] = largest > 0 ? std::nearbyint(values[i] * (127.0F / largest)) * double{largest} / 127 : 0;
  }
  return out;
}

struct Case {
  std::size_t rows, out, in;
};

/// A layer, rows for it, and what is added: all that a call reads.
struct Problem {
  explicit Problem(const Case& of)
      : size(of),
        x_stride(of.in + 3),
        y_stride(row_stride(of.out)),
        weight(numbers(of.out * of.in, 1)),
        bias(numbers(of.out, 2)),
        x(numbers(of.rows * x_stride, 3)),
        add(of.rows * y_stride) {
    const auto values = numbers(add.size(), 4);
    std::ranges::copy(values, add.data());
  }

  AlignedFloats solve(Precision precision) const { return solve(precision, 0, size.rows); }
  AlignedFloats solve(Precision precision, std::size_t first, std::size_t rows) const {
    const PackedLinear layer = pack_linear(weight, bias, size.out, size.in, 0, size.in, precision);
    ConvertedRows memory(rows, size.in);
    AlignedFloats y(rows * y_stride);
    apply_linear(layer, rows, {x.data() + first * x_stride, x_stride}, {y.data(), y_stride},
                 {.add = {add.data() + first * y_stride, y_stride}, .relu = true}, memory);
    return y;
  }

  Case size;
  std::size_t x_stride, y_stride;
  std::vector<float> weight, bias, x;
  AlignedFloats add;
};

const std::vector<Case> kCases = {{1, 53, 40},  {1, 768, 256}, {2, 96, 130}, {3, 288, 33},  {4, 64, 99},
                                  {5, 160, 70}, {11, 53, 40},  {12, 64, 31}, {13, 96, 130}, {121, 96, 65}};

/// Every variant that this machine can run in every precision, against plain loops in double precision.
class LinearLayers : public testing::TestWithParam<std::tuple<std::string_view, Precision>> {
 protected:
  void SetUp() override { force_kernel(std::get<0>(GetParam())); }
  void TearDown() override { force_kernel(""); }
  static Precision precision() { return std::get<1>(GetParam()); }
};

TEST_P(LinearLayers, AreWhatTheyShouldBe) {
  for (const Case& of : kCases) {
    const Problem problem(of);
    const AlignedFloats y = problem.solve(precision());
    std::vector<std::vector<double>> columns;
    for (std::size_t o = 0; o < of.out; ++o)
      columns.push_back(as(precision(), problem.weight.data() + o * of.in, of.in));
    for (std::size_t r = 0; r < of.rows; ++r) {
      const auto x = as(precision(), problem.x.data() + r * problem.x_stride, of.in);
      for (std::size_t o = 0; o < of.out; ++o) {
        double sum = double{problem.bias[o]} + double{problem.add[r * problem.y_stride + o]};
        for (std::size_t i = 0; i < of.in; ++i) sum += columns[o][i] * x[i];
        ASSERT_NEAR(y[r * problem.y_stride + o], std::max(sum, 0.0), 2e-5)
            << of.rows << " rows of " << of.out << " x " << of.in << ": " << r << " " << o;
      }
      for (std::size_t o = of.out; o < padded(of.out); ++o)
        ASSERT_EQ(y[r * problem.y_stride + o], std::max(problem.add[r * problem.y_stride + o], 0.0F));
    }
  }
}

TEST_P(LinearLayers, ARowAmongOthersIsTheRowAlone) {
  for (const Case& of : kCases) {
    const Problem problem(of);
    const AlignedFloats together = problem.solve(precision());
    for (std::size_t r = 0; r < of.rows; r += 5) {
      const AlignedFloats alone = problem.solve(precision(), r, 1);
      for (std::size_t o = 0; o < of.out; ++o) ASSERT_EQ(alone[o], together[r * problem.y_stride + o]);
    }
  }
}

TEST_P(LinearLayers, OfSomeColumns) {
  const std::size_t out = 40, total = 50, first = 11, count = 20;
  const auto weight = numbers(out * total, 1), x = numbers(count, 3);
  AlignedFloats y(padded(out));
  ConvertedRows memory(1, count);
  const auto layer = pack_linear(weight, {}, out, total, first, count, precision());
  apply_linear(layer, 1, {x.data(), count}, {y.data(), padded(out)}, {}, memory);
  const auto input = as(precision(), x.data(), count);
  for (std::size_t o = 0; o < out; ++o) {
    const auto column = as(precision(), weight.data() + o * total + first, count);
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += column[i] * input[i];
    EXPECT_NEAR(y[o], sum, 1e-5);
  }
  for (std::size_t o = out; o < padded(out); ++o) EXPECT_EQ(y[o], 0);
}

TEST_P(LinearLayers, OfNothingButZeros) {
  const std::vector<float> weight(40 * 20), x(20);
  AlignedFloats y(padded(40));
  ConvertedRows memory(1, 20);
  apply_linear(pack_linear(weight, {}, 40, 20, 0, 20, precision()), 1, {x.data(), 20}, {y.data(), padded(40)},
               {}, memory);
  for (std::size_t o = 0; o < 40; ++o) EXPECT_EQ(y[o], 0);
}

TEST_P(LinearLayers, Products) {
  const std::size_t rows = 13, depth = 45, columns = 64;
  const auto a = numbers(rows * depth, 5), b_values = numbers(depth * columns, 6);
  AlignedFloats b(depth * columns), c(rows * columns);
  std::ranges::copy(b_values, b.data());
  multiply(rows, depth, columns, {a.data(), depth}, {b.data(), columns}, {c.data(), columns});
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t j = 0; j < columns; ++j) {
      double sum = 0;
      for (std::size_t k = 0; k < depth; ++k) sum += double{a[r * depth + k]} * double{b[k * columns + j]};
      ASSERT_NEAR(c[r * columns + j], sum, 1e-5);
    }
}

INSTANTIATE_TEST_SUITE_P(All, LinearLayers,
                         testing::Combine(testing::ValuesIn(available_kernels()),
                                          testing::Values(Precision::fp32, Precision::bf16, Precision::int8)),
                         [](const auto& of) {
                           return std::string(std::get<0>(of.param)) + "_" +
                                  std::string(precision_name(std::get<1>(of.param)));
                         });

TEST(Precisions, Bf16AndInt8AreTheSameBitsInEveryVariant) {
  for (const std::string_view variant : available_kernels())
    for (const Precision precision : {Precision::bf16, Precision::int8}) {
      const bool fuses = variant != "SSE4" && variant != "SSSE3";
      if (precision == Precision::bf16 && !fuses) continue;
      for (const Case& of : kCases) {
        const Problem problem(of);
        const AlignedFloats best = problem.solve(precision);
        force_kernel(variant);
        const AlignedFloats here = problem.solve(precision);
        force_kernel("");
        for (std::size_t i = 0; i < here.size(); ++i) ASSERT_EQ(here[i], best[i]) << variant;
      }
    }
}

TEST(Precisions, AreFoundByTheirNames) {
  for (const Precision p : {Precision::fp32, Precision::bf16, Precision::int8})
    EXPECT_EQ(precision_from_name(precision_name(p)), p);
  EXPECT_FALSE(precision_from_name("fp16"));
  EXPECT_EQ(kernel_name(Precision::fp32), kernel_name());
  EXPECT_NE(kernel_name(Precision::int8), kernel_name());
}

}  // namespace
}  // namespace mien::model::linear_test
