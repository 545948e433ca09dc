#include "mien/model/convolution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "tests/model/numbers.h"

namespace mien::model::convolution_test {
namespace {

using Doubles = std::vector<double>;

/// A convolution in plain loops: channels of lines of pixels, as libtorch has them.
Doubles convolved_plainly(const Doubles& x, const MapSize& in, const std::vector<float>& weight,
                          const std::vector<float>& bias, std::size_t out, std::size_t stride) {
  const MapSize to = convolved(in, stride, out);
  Doubles y(to.height * to.width * out);
  for (std::size_t o = 0; o < out; ++o)
    for (std::size_t i = 0; i < to.height; ++i)
      for (std::size_t j = 0; j < to.width; ++j) {
        double sum = double{bias[o]};
        for (std::size_t c = 0; c < in.channels; ++c)
          for (std::size_t ky = 0; ky < 3; ++ky)
            for (std::size_t kx = 0; kx < 3; ++kx) {
              const std::size_t line = i * stride + ky, pixel = j * stride + kx;  // One more than in the map.
              if (line == 0 || pixel == 0 || line > in.height || pixel > in.width) continue;
              sum += x[(c * in.height + line - 1) * in.width + pixel - 1] *
                     double{weight[((o * in.channels + c) * 3 + ky) * 3 + kx]};
            }
        y[(o * to.height + i) * to.width + j] = std::max(sum, 0.0);
      }
  return y;
}

double number_at(const FeatureMaps& maps, std::size_t map, std::size_t line, std::size_t pixel,
                 std::size_t channel) {
  const std::byte* at = maps.at(map, line, pixel);
  switch (maps.precision()) {
    case Precision::fp32:
      return double{reinterpret_cast<const float*>(at)[channel]};
    case Precision::bf16:
      return double{std::bit_cast<float>(
          static_cast<std::uint32_t>(reinterpret_cast<const std::uint16_t*>(at)[channel]) << 16)};
    case Precision::int8:
      break;
  }
  return static_cast<double>(at[channel]) * double{maps.scales()[map]};
}

/// A map's numbers, and whether all zeros around and between them are there.
Doubles numbers_of(const FeatureMaps& maps, std::size_t map) {
  const auto [height, width, channels] = maps.size();
  Doubles out(height * width * channels);
  for (std::size_t line = 0; line < height + 2; ++line)
    for (std::size_t pixel = 0; pixel < width + 2; ++pixel) {
      const bool inside = line > 0 && pixel > 0 && line <= height && pixel <= width;
      for (std::size_t c = 0; c < maps.pixel(); ++c) {
        const double number = number_at(maps, map, line, pixel, c);
        if (inside && c < channels)
          out[(c * height + line - 1) * width + pixel - 1] = number;
        else
          EXPECT_EQ(number, 0) << line << " " << pixel << " " << c;
      }
    }
  return out;
}

/// Of its largest number.
double tolerance(Precision precision) {
  return precision == Precision::fp32 ? 1e-5 : precision == Precision::bf16 ? 0.01 : 0.02;
}

void expect_near(const Doubles& got, const Doubles& expected, double share) {
  ASSERT_EQ(got.size(), expected.size());
  const double largest = *std::ranges::max_element(expected);
  ASSERT_GT(largest, 0);
  for (std::size_t i = 0; i < got.size(); ++i) ASSERT_NEAR(got[i], expected[i], share * largest) << i;
}

struct Case {
  std::size_t height, width, in, out, stride;
};

/// Two convolutions on top of each other, the first of a picture.
struct Problem {
  explicit Problem(const Case& of)
      : size(of),
        first_weight(numbers(of.in * 9, 1)),
        first_bias(numbers(of.in, 2)),
        weight(numbers(of.out * of.in * 9, 3)),
        bias(numbers(of.out, 4)) {}

  [[nodiscard]] MapSize picture_size() const { return {size.height, size.width, 1}; }
  [[nodiscard]] MapSize between() const { return convolved(picture_size(), 1, size.in); }
  [[nodiscard]] std::vector<float> picture(std::size_t i) const {
    return numbers(size.height * size.width, 5 + i);
  }

  struct Maps {
    FeatureMaps between, out;
  };
  [[nodiscard]] Maps solve(Precision precision, const std::vector<std::vector<float>>& pictures) const {
    const std::size_t count = pictures.size(), line = size.width + 2;
    Maps maps{FeatureMaps(between(), 16, count, precision),
              FeatureMaps(convolved(between(), size.stride, size.out), kPanel, count, precision)};
    ConvolutionMemory memory;
    memory.reserve(maps.between);
    memory.reserve(maps.between, maps.out, count);
    const auto first = pack_picture_convolution(first_weight, first_bias, size.in, 1);
    const auto second =
        pack_convolution(weight, bias, size.out, size.in, maps.between.pixel(), size.stride, precision);
    for (std::size_t i = 0; i < count; ++i) {
      std::vector<float> surrounded(line * (size.height + 2));
      for (std::size_t y = 0; y < size.height; ++y)
        std::copy_n(pictures[i].data() + y * size.width, size.width, surrounded.data() + (y + 1) * line + 1);
      convolve_picture(first, surrounded.data(), line, maps.between, i, memory);
    }
    convolve(second, maps.between, 0, maps.out, 0, count, memory);
    return maps;
  }

  Case size;
  std::vector<float> first_weight, first_bias, weight, bias;
};

const std::vector<Case> kCases = {{24, 24, 16, 32, 2}, {13, 31, 5, 7, 2}, {9, 9, 20, 40, 2},
                                  {5, 4, 33, 96, 2},   {6, 7, 3, 31, 1},  {3, 3, 17, 65, 1},
                                  {1, 1, 8, 9, 2},     {2, 50, 1, 1, 2}};

/// Every variant that this machine can run in every precision, against plain loops in double precision.
class Convolutions : public testing::TestWithParam<std::tuple<std::string_view, Precision>> {
 protected:
  void SetUp() override { force_kernel(std::get<0>(GetParam())); }
  void TearDown() override { force_kernel(""); }
  static Precision precision() { return std::get<1>(GetParam()); }
};

TEST_P(Convolutions, AreWhatTheyShouldBe) {
  for (const Case& of : kCases) {
    SCOPED_TRACE(testing::Message() << of.height << " x " << of.width << ", " << of.in << " to " << of.out);
    const Problem problem(of);
    const auto picture = problem.picture(0);
    const Problem::Maps maps = problem.solve(precision(), {picture});
    const Doubles between = numbers_of(maps.between, 0);
    expect_near(between,
                convolved_plainly(Doubles(picture.begin(), picture.end()), problem.picture_size(),
                                  problem.first_weight, problem.first_bias, of.in, 1),
                tolerance(precision()));
    // The second reads what the first has rounded.
    expect_near(
        numbers_of(maps.out, 0),
        convolved_plainly(between, problem.between(), problem.weight, problem.bias, of.out, of.stride),
        tolerance(precision()));
  }
}

TEST_P(Convolutions, AMapAmongOthersIsTheMapAlone) {
  for (const Case& of : kCases) {
    const Problem problem(of);
    const auto together =
        problem.solve(precision(), {problem.picture(0), problem.picture(1), problem.picture(2)});
    for (std::size_t i = 0; i < 3; ++i) {
      const auto alone = problem.solve(precision(), {problem.picture(i)});
      ASSERT_TRUE(std::equal(alone.out.at(0, 0, 0), alone.out.at(0, 0, 0) + alone.out.map_bytes(),
                             together.out.at(i, 0, 0)));
    }
  }
}

/// The largest bytes that a group of int8's words may have, all of one sign: nothing may be lost in 16 bits.
TEST_P(Convolutions, OfTheLargestNumbers) {
  const MapSize size{6, 12, 16};
  for (const float sign : {1.0F, -1.0F}) {
    const std::vector<float> weight(4 * 16 * 9, sign), bias(4, sign < 0 ? 2000.0F : 0.0F);
    FeatureMaps in(size, 16, 1, precision()), out(convolved(size, 2, 4), kPanel, 1, precision());
    ConvolutionMemory memory;
    memory.reserve(in);
    memory.reserve(in, out, 1);
    // A picture of ones through a first layer that only copies.
    std::vector<float> copy(16 * 9), none(16), picture(8 * 14);
    for (std::size_t c = 0; c < 16; ++c) copy[c * 9 + 4] = 10;
    for (std::size_t y = 1; y <= 6; ++y) std::fill_n(picture.data() + y * 14 + 1, 12, 1.0F);
    convolve_picture(pack_picture_convolution(copy, none, 16, 1), picture.data(), 14, in, 0, memory);
    convolve(pack_convolution(weight, bias, 4, 16, 16, 2, precision()), in, 0, out, 0, 1, memory);
    const double inside = 9 * 16 * 10, corner = 4 * 16 * 10;
    const Doubles y = numbers_of(out, 0);
    EXPECT_NEAR(y[0], sign < 0 ? 2000 - corner : corner, 30);
    EXPECT_NEAR(y[1 * 6 + 1], sign < 0 ? 2000 - inside : inside, 30);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Convolutions,
                         testing::Combine(testing::ValuesIn(available_kernels()),
                                          testing::Values(Precision::fp32, Precision::bf16, Precision::int8)),
                         [](const auto& of) {
                           return std::string(std::get<0>(of.param)) + "_" +
                                  std::string(precision_name(std::get<1>(of.param)));
                         });

TEST(Convolution, Int8IsTheSameBitsInEveryVariantThatFuses) {
  for (const std::string_view variant : available_kernels()) {
    if (variant == "SSE4" || variant == "SSSE3") continue;
    for (const Case& of : kCases) {
      const Problem problem(of);
      const auto best = problem.solve(Precision::int8, {problem.picture(0)});
      force_kernel(variant);
      const auto here = problem.solve(Precision::int8, {problem.picture(0)});
      force_kernel("");
      ASSERT_TRUE(
          std::equal(best.out.at(0, 0, 0), best.out.at(0, 0, 0) + best.out.map_bytes(), here.out.at(0, 0, 0)))
          << variant;
    }
  }
}

}  // namespace
}  // namespace mien::model::convolution_test
