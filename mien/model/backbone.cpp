#include "mien/model/backbone.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <string>

#include "mien/model/picture_line.h"
#include "mien/model/product.h"

namespace mien::model {
namespace {

constexpr std::size_t kStride = 2;
constexpr std::size_t kLeastSize = 8, kLargestSize = 256, kMostChannels = 1024, kMostFeatures = 4096;

Result<void> check_number(const std::string& what, std::size_t n, std::size_t least, std::size_t most) {
  if (n >= least && n <= most) return {};
  return fail(ErrorCode::out_of_range, fmt::format("{} is {}, not {} to {}", what, n, least, most));
}

/// The last layer's weights, [features, channels, height, width], in the order in which a map of the run time
/// has them: [features, height, width, pixel].
std::vector<float> by_pixels(std::span<const float> weight, std::size_t features, const MapSize& map,
                             std::size_t pixel) {
  const std::size_t places = map.height * map.width;
  std::vector<float> rows(features * places * pixel);
  for (std::size_t f = 0; f < features; ++f)
    for (std::size_t c = 0; c < map.channels; ++c)
      for (std::size_t place = 0; place < places; ++place)
        rows[(f * places + place) * pixel + c] = weight[(f * map.channels + c) * places + place];
  return rows;
}

}  // namespace

Result<void> check(const BackboneShape& shape) {
  MIEN_TRY(check_number("the pictures' size", shape.size, kLeastSize, kLargestSize));
  MIEN_TRY(check_number("the number of convolutions", shape.widths.size(), 1, kMostConvolutions));
  for (const std::size_t width : shape.widths)
    MIEN_TRY(check_number("a convolution's channels", width, 1, kMostChannels));
  return check_number("the number of features", shape.features, 1, kMostFeatures);
}

MapSize map_size(const BackboneShape& shape, std::size_t convolutions) {
  MapSize size{shape.size, shape.size, 1};
  for (std::size_t i = 0; i < convolutions; ++i) size = convolved(size, kStride, shape.widths[i]);
  return size;
}

std::vector<TensorSpec> tensor_specs(const BackboneShape& shape) {
  std::vector<TensorSpec> specs;
  for (std::size_t i = 0; i < shape.widths.size(); ++i) {
    const std::string name = fmt::format("convolutions.{}", i);
    specs.push_back({name + ".weight", {shape.widths[i], map_size(shape, i).channels, 3, 3}});
    specs.push_back({name + ".bias", {shape.widths[i]}});
  }
  const MapSize last = map_size(shape, shape.widths.size());
  specs.push_back({"features.weight", {shape.features, last.channels * last.height * last.width}});
  specs.push_back({"features.bias", {shape.features}});
  return specs;
}

double flop_count(const BackboneShape& shape) {
  const auto numbers = [&](std::size_t i) {
    const MapSize size = map_size(shape, i);
    return static_cast<double>(size.height * size.width * size.channels);
  };
  double count = 2 * numbers(shape.widths.size()) * static_cast<double>(shape.features);
  for (std::size_t i = 0; i < shape.widths.size(); ++i)
    count += 2 * 9 * numbers(i + 1) * static_cast<double>(map_size(shape, i).channels);
  return count;
}

Result<Backbone> Backbone::create(const BackboneShape& shape, std::span<const Tensor> tensors,
                                  Precision precision) {
  MIEN_TRY(check(shape));
  MIEN_TRY(check_tensors(tensor_specs(shape), tensors));
  for (const Tensor& tensor : tensors)
    if (!std::ranges::all_of(tensor.values, [](float v) { return std::isfinite(v); }))
      return fail(ErrorCode::out_of_range,
                  fmt::format("tensor {} has numbers that are not finite", tensor.name));

  Backbone result;
  result.shape_ = shape;
  result.first_ = pack_picture_convolution(tensors[0].values, tensors[1].values, shape.widths[0], kStride);
  std::size_t pixel = result.first_.bias.size();
  for (std::size_t i = 1; i < shape.widths.size(); ++i) {
    result.layers_.push_back(pack_convolution(tensors[2 * i].values, tensors[2 * i + 1].values,
                                              shape.widths[i], shape.widths[i - 1], pixel, kStride,
                                              precision));
    pixel = padded(shape.widths[i]);
  }
  while (result.together_ < result.layers_.size()) {
    const MapSize in = map_size(shape, result.together_ + 1);
    const PackedLinear& product = result.layers_[result.together_].product;
    if (product.out * product.in > in.height * in.width * in.channels) break;
    ++result.together_;
  }
  const MapSize last = map_size(shape, shape.widths.size());
  const std::size_t places = last.height * last.width;
  result.features_ = pack_linear(by_pixels(tensors[tensors.size() - 2].values, shape.features, last, pixel),
                                 tensors.back().values, shape.features, places * pixel, 0, places * pixel,
                                 precision, Inputs::nonnegative);
  return result;
}

Backbone::Workspace::Workspace(const Backbone& backbone, std::size_t pictures)
    : pictures_(pictures),
      line_(backbone.shape_.size + 2),
      picture_(line_ * line_),
      answers_(pictures * padded(backbone.shape_.features)) {
  const std::size_t layers = backbone.layers_.size();
  for (std::size_t i = 0; i <= layers; ++i)
    maps_.emplace_back(map_size(backbone.shape_, i + 1), i == 0 ? kPictureChannels : kPanel,
                       i >= backbone.together_ ? pictures : 1, backbone.precision());
  memory_.reserve(maps_.front());
  for (std::size_t i = 0; i < layers; ++i)
    memory_.reserve(maps_[i], maps_[i + 1], i >= backbone.together_ ? pictures : 1);
}

std::size_t Backbone::weight_bytes() const {
  return std::accumulate(
      layers_.begin(), layers_.end(), first_.weight.size() * sizeof(float) + features_.weights.size(),
      [](std::size_t sum, const PackedConvolution& layer) { return sum + layer.product.weights.size(); });
}

/// The layers through which a picture goes alone, into `map` of the first that all go through together.
void Backbone::apply_first(std::span<const float> picture, std::size_t map, Workspace& w) const {
  for (std::size_t y = 0; y < shape_.size; ++y)
    std::copy_n(picture.data() + y * shape_.size, shape_.size, w.picture_.data() + (y + 1) * w.line_ + 1);
  convolve_picture(first_, w.picture_.data(), w.line_, w.maps_[0], together_ == 0 ? map : 0, w.memory_);
  for (std::size_t i = 0; i < together_; ++i)
    convolve(layers_[i], w.maps_[i], 0, w.maps_[i + 1], i + 1 == together_ ? map : 0, 1, w.memory_);
}

void Backbone::apply(std::span<const float> pictures, Workspace& w, std::span<float> features) const {
  const std::size_t numbers = shape_.size * shape_.size, count = pictures.size() / numbers;
  assert(pictures.size() == count * numbers && count <= w.pictures_ &&
         features.size() == count * shape_.features);
  for (std::size_t i = 0; i < count; ++i) apply_first(pictures.subspan(i * numbers, numbers), i, w);
  for (std::size_t i = together_; i < layers_.size(); ++i)
    convolve(layers_[i], w.maps_[i], 0, w.maps_[i + 1], 0, count, w.memory_);

  // A picture's last map is a row of the product, line after line.
  const FeatureMaps& last = w.maps_.back();
  const std::size_t answer = padded(shape_.features);
  Product product = product_of(features_);
  product.runs = last.size().height;
  product.words /= product.runs;
  product.run_step = last.line_bytes();
  product.a = last.at(0, 1, 1);
  product.a_stride = last.map_bytes();
  product.c = w.answers_.data();
  product.c_stride = answer;
  product.row_scale = last.scales();
  multiplier(features_.precision, true).multiply(count, answer / kPanel, product);
  for (std::size_t i = 0; i < count; ++i)
    std::copy_n(w.answers_.data() + i * answer, shape_.features, features.data() + i * shape_.features);
}

}  // namespace mien::model
