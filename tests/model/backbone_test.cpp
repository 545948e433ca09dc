#include "mien/model/backbone.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "tests/allocation_count.h"
#include "tests/model/numbers.h"
#include "tests/model/random_backbone.h"

namespace mien::model::backbone_test {
namespace {

using testing::HasSubstr;

/// The whole network in plain loops of doubles, as libtorch would run it.
std::vector<double> run_plainly(const BackboneShape& shape, const std::vector<Tensor>& tensors,
                                const std::vector<float>& picture) {
  std::vector<double> x(picture.begin(), picture.end());
  for (std::size_t i = 0; i < shape.widths.size(); ++i) {
    const MapSize in = map_size(shape, i), out = map_size(shape, i + 1);
    const std::vector<float>&weight = tensors[2 * i].values, &bias = tensors[2 * i + 1].values;
    std::vector<double> y;
    for (std::size_t o = 0; o < out.channels; ++o)
      for (std::size_t line = 0; line < out.height; ++line)
        for (std::size_t pixel = 0; pixel < out.width; ++pixel) {
          double sum = double{bias[o]};
          for (std::size_t c = 0; c < in.channels; ++c)
            for (std::size_t k = 0; k < 9; ++k) {
              const std::size_t from_line = 2 * line + k / 3, from_pixel = 2 * pixel + k % 3;
              if (from_line == 0 || from_pixel == 0 || from_line > in.height || from_pixel > in.width)
                continue;
              sum += x[(c * in.height + from_line - 1) * in.width + from_pixel - 1] *
                     double{weight[(o * in.channels + c) * 9 + k]};
            }
          y.push_back(std::max(sum, 0.0));
        }
    x = std::move(y);
  }
  std::vector<double> features;
  for (std::size_t f = 0; f < shape.features; ++f) {
    double sum = double{tensors.back().values[f]};
    for (std::size_t i = 0; i < x.size(); ++i)
      sum += double{tensors[tensors.size() - 2].values[f * x.size() + i]} * x[i];
    features.push_back(sum);
  }
  return features;
}

std::vector<float> picture_of(const BackboneShape& shape, std::uint64_t seed) {
  auto values = numbers(shape.size * shape.size, seed);
  for (float& v : values) v = 0.5F + 0.5F * v;
  return values;
}

std::vector<float> run(const Backbone& backbone, const std::vector<float>& pictures, std::size_t count) {
  Backbone::Workspace workspace(backbone, count);
  std::vector<float> features(count * backbone.shape().features);
  backbone.apply(pictures, workspace, features);
  return features;
}

const std::vector<BackboneShape> kShapes = {
    {}, {64, {16, 24, 40}, 10}, {33, {5, 7, 11, 13}, 3}, {8, {1}, 1}, {128, {16, 32, 64, 96, 128, 130}, 96}};

class Backbones : public testing::TestWithParam<std::tuple<std::string_view, Precision>> {
 protected:
  void SetUp() override { force_kernel(std::get<0>(GetParam())); }
  void TearDown() override { force_kernel(""); }
  static Precision precision() { return std::get<1>(GetParam()); }
};

TEST_P(Backbones, AreWhatTheyShouldBe) {
  const double tolerance = precision() == Precision::fp32   ? 1e-5
                           : precision() == Precision::bf16 ? 0.015
                                                            : 0.05;
  for (const BackboneShape& shape : kShapes) {
    const auto tensors = random_backbone(shape, 1);
    const Backbone backbone = Backbone::create(shape, tensors, precision()).value();
    const auto picture = picture_of(shape, 2);
    const auto features = run(backbone, picture, 1);
    const auto expected = run_plainly(shape, tensors, picture);
    double largest = 0;
    for (const double v : expected) largest = std::max(largest, std::abs(v));
    for (std::size_t i = 0; i < features.size(); ++i)
      ASSERT_NEAR(features[i], expected[i], tolerance * largest) << shape.size << " pixels, feature " << i;
  }
}

TEST_P(Backbones, APictureAmongOthersIsThePictureAlone) {
  for (const BackboneShape& shape : kShapes) {
    const Backbone backbone = Backbone::create(shape, random_backbone(shape, 1), precision()).value();
    std::vector<float> pictures, alone;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto picture = picture_of(shape, i);
      pictures.insert(pictures.end(), picture.begin(), picture.end());
      const auto features = run(backbone, picture, 1);
      alone.insert(alone.end(), features.begin(), features.end());
    }
    ASSERT_EQ(run(backbone, pictures, 3), alone);
    // A workspace for more, which has seen other pictures.
    Backbone::Workspace workspace(backbone, 4);
    std::vector<float> features(alone.size());
    backbone.apply(pictures, workspace, features);
    const auto first = std::span(features).first(shape.features);
    backbone.apply(std::span(pictures).first(shape.size * shape.size), workspace, first);
    ASSERT_TRUE(std::ranges::equal(first, std::span(alone).first(shape.features)));
  }
}

INSTANTIATE_TEST_SUITE_P(All, Backbones,
                         testing::Combine(testing::ValuesIn(available_kernels()),
                                          testing::Values(Precision::fp32, Precision::bf16, Precision::int8)),
                         [](const auto& of) {
                           return std::string(std::get<0>(of.param)) + "_" +
                                  std::string(precision_name(std::get<1>(of.param)));
                         });

/// Windows of stride 2 with a pixel of zeros around lie symmetrically only in odd maps: 65, 33, 17, 9, 5, 3.
TEST(Backbone, AMirroredPictureThroughMirroredWeightsIsTheSame) {
  const BackboneShape shape{65, {16, 32, 24, 40, 20}, 12};
  const auto tensors = random_backbone(shape, 3);
  auto mirrored = tensors;
  const auto mirror_lines = [](std::vector<float>& values, std::size_t width) {
    for (std::size_t at = 0; at < values.size(); at += width)
      std::reverse(values.begin() + static_cast<std::ptrdiff_t>(at),
                   values.begin() + static_cast<std::ptrdiff_t>(at + width));
  };
  for (std::size_t i = 0; i < shape.widths.size(); ++i) mirror_lines(mirrored[2 * i].values, 3);
  mirror_lines(mirrored[mirrored.size() - 2].values, map_size(shape, shape.widths.size()).width);
  auto picture = picture_of(shape, 4);
  const auto features = run(Backbone::create(shape, tensors).value(), picture, 1);
  mirror_lines(picture, shape.size);
  const auto of_mirrored = run(Backbone::create(shape, mirrored).value(), picture, 1);
  for (std::size_t i = 0; i < features.size(); ++i) EXPECT_NEAR(of_mirrored[i], features[i], 1e-5) << i;
}

TEST(Backbone, APictureAllocatesNothing) {
  const BackboneShape shape;
  for (const Precision precision : {Precision::fp32, Precision::bf16, Precision::int8}) {
    const Backbone backbone = Backbone::create(shape, random_backbone(shape, 1), precision).value();
    Backbone::Workspace workspace(backbone, 2);
    const std::vector<float> pictures(2 * 96 * 96, 0.5F);
    std::vector<float> features(2 * 96);
    const std::size_t before = test::allocation_count();
    backbone.apply(pictures, workspace, features);
    EXPECT_EQ(test::allocation_count(), before);
  }
}

TEST(Backbone, SaysHowMuchItIs) {
  const BackboneShape shape;
  EXPECT_EQ(map_size(shape, 5), (MapSize{3, 3, 128}));
  // 48 x 48 x 16 x 9, 24 x 24 x 32 x 144, 12 x 12 x 64 x 288, 6 x 6 x 96 x 576, 3 x 3 x 128 x 864, 1152 x 96.
  EXPECT_EQ(flop_count(shape), 2.0 * (331776 + 2654208 + 2654208 + 1990656 + 995328 + 110592));
  EXPECT_EQ(tensor_specs(shape).front(), (TensorSpec{"convolutions.0.weight", {16, 1, 3, 3}}));
  EXPECT_EQ(tensor_specs(shape)[10], (TensorSpec{"features.weight", {96, 1152}}));
  const auto bytes = [&](Precision precision) {
    return Backbone::create(shape, random_backbone(shape, 1), precision)->weight_bytes();
  };
  EXPECT_EQ(bytes(Precision::fp32), 4 * (9 * 16 + 144 * 32 + 288 * 64 + 576 * 96 + 864 * 128 + 1152 * 96));
  EXPECT_LT(bytes(Precision::int8), 0.26 * static_cast<double>(bytes(Precision::fp32)));
}

TEST(Backbone, RefusesShapesAndTensorsThatDoNotFit) {
  const auto refused = [](const BackboneShape& shape) { return check(shape).error(); };
  EXPECT_EQ(refused({.size = 7}).code, ErrorCode::out_of_range);
  EXPECT_EQ(refused({.size = 257}).code, ErrorCode::out_of_range);
  EXPECT_EQ(refused({.widths = {}}).code, ErrorCode::out_of_range);
  EXPECT_EQ(refused({.widths = std::vector<std::size_t>(9, 1)}).code, ErrorCode::out_of_range);
  EXPECT_THAT(refused({.widths = {16, 0}}).what, HasSubstr("channels is 0, not 1 to 1024"));
  EXPECT_EQ(refused({.widths = {1025}}).code, ErrorCode::out_of_range);
  EXPECT_EQ(refused({.features = 0}).code, ErrorCode::out_of_range);
  EXPECT_EQ(refused({.features = 4097}).code, ErrorCode::out_of_range);

  const BackboneShape shape{16, {4, 6}, 5};
  auto tensors = random_backbone(shape, 1);
  EXPECT_TRUE(Backbone::create(shape, tensors));
  EXPECT_EQ(Backbone::create({.size = 3}, tensors).error().code, ErrorCode::out_of_range);
  EXPECT_THAT(Backbone::create({32, {4, 6}, 5}, tensors).error().what, HasSubstr("features.weight"));
  tensors[1].values[2] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(Backbone::create(shape, tensors).error().code, ErrorCode::out_of_range);
  tensors[1].values[2] = 0;
  std::swap(tensors[0], tensors[2]);
  EXPECT_EQ(Backbone::create(shape, tensors).error().code, ErrorCode::mismatch);
  std::swap(tensors[0], tensors[2]);
  tensors.pop_back();
  EXPECT_EQ(Backbone::create(shape, tensors).error().code, ErrorCode::mismatch);
}

}  // namespace
}  // namespace mien::model::backbone_test
