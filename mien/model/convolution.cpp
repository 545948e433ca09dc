#include "mien/model/convolution.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <vector>

#include "mien/model/picture_line.h"
#include "mien/model/product.h"

namespace mien::model {
namespace {

constexpr std::size_t kSide = 3;  ///< Pixels of a convolution's window, either way.
/// Narrower maps are gathered: their lines by themselves would be products of few rows.
constexpr std::size_t kDirectWidth = 6;

std::size_t rounded_up(std::size_t n, std::size_t step) {
  return (n + step - 1) / step * step;
}

/// Bytes of a gathered row, a cache line more than it needs: rows at a power of two from each other would
/// fight for one place in the cache.
std::size_t gathered_stride(const FeatureMaps& in) {
  return rounded_up(kSide * kSide * in.pixel_bytes(), kLineBytes) + kLineBytes;
}

/// Weights of paired lines that are more than this do not stay in the second cache.
constexpr std::size_t kPairedBytes = std::size_t{400} << 10;

/// `rows`: out rows of three lines of `line` weights each.
PairedLines pack_pairs(std::span<const float> rows, std::span<const float> bias, std::size_t out,
                       std::size_t line) {
  std::vector<float> shared, upper, lower;
  for (std::size_t o = 0; o < out; ++o) {
    const auto row = rows.subspan(o * kSide * line, kSide * line);
    const auto u = row.first(line), v = row.subspan(line, line), w = row.last(line);
    for (std::size_t i = 0; i < line; ++i) shared.push_back(u[i] + w[i]);
    upper.insert(upper.end(), u.begin(), u.end());
    upper.insert(upper.end(), v.begin(), v.end());
    lower.insert(lower.end(), v.begin(), v.end());
    for (const float weight : w) lower.push_back(-weight);
  }
  const auto pack = [&](std::span<const float> weights, std::span<const float> with, std::size_t lines) {
    return pack_linear(weights, with, out, lines * line, 0, lines * line, Precision::fp32,
                       Inputs::nonnegative);
  };
  return {pack(shared, bias, 1), pack(upper, {}, 2), pack(lower, {}, 2)};
}

/// Calls make_line(y, where) for each line of a map, and puts what it wrote into the map's precision.
template <class MakeLine>
void fill_map(FeatureMaps& out, std::size_t map, float* answers, const MakeLine& make_line) {
  const std::size_t height = out.size().height, count = out.size().width * out.pixel();
  switch (out.precision()) {
    case Precision::fp32:
      for (std::size_t y = 0; y < height; ++y) make_line(y, reinterpret_cast<float*>(out.at(map, y + 1, 1)));
      break;
    case Precision::bf16:
      for (std::size_t y = 0; y < height; ++y) {
        make_line(y, answers);
        round_row(count, answers, reinterpret_cast<std::uint16_t*>(out.at(map, y + 1, 1)));
      }
      break;
    case Precision::int8: {
      float largest = 0;
      for (std::size_t y = 0; y < height; ++y) {
        make_line(y, answers + y * count);
        largest = std::max(largest, largest_number(count, answers + y * count));
      }
      for (std::size_t y = 0; y < height; ++y)
        quantise_nonnegative(count, largest, answers + y * count,
                             reinterpret_cast<std::uint8_t*>(out.at(map, y + 1, 1)));
      out.scales()[map] = largest / 127.0F;
      break;
    }
  }
}

}  // namespace

FeatureMaps::FeatureMaps(const MapSize& size, std::size_t channel_step, std::size_t count,
                         Precision precision)
    : size_(size),
      precision_(precision),
      pixel_(rounded_up(size.channels, channel_step)),
      numbers_(count * map_bytes()),
      scales_(count) {}

PackedConvolution pack_convolution(std::span<const float> weight, std::span<const float> bias,
                                   std::size_t out, std::size_t in, std::size_t in_pixel, std::size_t stride,
                                   Precision precision) {
  assert(weight.size() == out * in * kSide * kSide && in <= in_pixel && stride >= 1);
  const std::size_t places = kSide * kSide, width = places * in_pixel;
  std::vector<float> rows(out * width);
  for (std::size_t o = 0; o < out; ++o)
    for (std::size_t c = 0; c < in; ++c)
      for (std::size_t place = 0; place < places; ++place)
        rows[o * width + place * in_pixel + c] = weight[(o * in + c) * places + place];
  PackedConvolution packed{
      .stride = stride,
      .in_pixel = in_pixel,
      .product = pack_linear(rows, bias, out, width, 0, width, precision, Inputs::nonnegative),
      .pairs = std::nullopt};
  const std::size_t paired_bytes = 5 * kSide * in_pixel * padded(out) * sizeof(float);
  if (precision == Precision::fp32 && stride == 2 && paired_bytes <= kPairedBytes)
    packed.pairs = pack_pairs(rows, bias, out, kSide * in_pixel);
  return packed;
}

PictureConvolution pack_picture_convolution(std::span<const float> weight, std::span<const float> bias,
                                            std::size_t out, std::size_t stride) {
  assert(weight.size() == out * kSide * kSide && bias.size() == out && stride >= 1);
  const std::size_t channels = rounded_up(out, kPictureChannels);
  PictureConvolution packed{.stride = stride,
                            .out = out,
                            .weight = AlignedFloats(kSide * kSide * channels),
                            .bias = AlignedFloats(channels)};
  for (std::size_t o = 0; o < out; ++o)
    for (std::size_t place = 0; place < kSide * kSide; ++place)
      packed.weight[place * channels + o] = weight[o * kSide * kSide + place];
  std::ranges::copy(bias, packed.bias.data());
  return packed;
}

void ConvolutionMemory::reserve(const FeatureMaps& out) {
  const std::size_t numbers = out.size().height * out.size().width * out.pixel();
  if (out.precision() != Precision::fp32 && answers_.size() < numbers) answers_ = AlignedFloats(numbers);
}

void ConvolutionMemory::reserve(const FeatureMaps& in, const FeatureMaps& out, std::size_t count) {
  reserve(out);
  const bool gathers = out.size().width < kDirectWidth;
  const std::size_t rows = gathers ? count * out.size().height * out.size().width : out.size().width;
  if (row_scales_.size() < rows) row_scales_ = AlignedFloats(rows);
  if (!gathers) {
    const std::size_t numbers = (in.size().width + 2) * in.pixel(), shared = rows * out.pixel();
    if (in.precision() == Precision::fp32 && differences_.size() < numbers)
      differences_ = AlignedFloats(numbers);
    if (in.precision() == Precision::fp32 && shared_.size() < shared) shared_ = AlignedFloats(shared);
    return;
  }
  if (rows_.size() < rows * gathered_stride(in)) rows_ = Aligned<std::byte>(rows * gathered_stride(in));
  if (row_answers_.size() < rows * out.pixel()) row_answers_ = AlignedFloats(rows * out.pixel());
}

/// The upper line of a pair leaves behind what the lower one shares with it.
void ConvolutionMemory::convolve_paired(const PairedLines& pairs, const FeatureMaps& in, std::size_t map,
                                        std::size_t y, RowsOut to, std::size_t width) {
  const auto line = [&](std::size_t i) {
    return reinterpret_cast<const float*>(in.at(map, y / 2 * 4 + i, 0));
  };
  const std::size_t numbers = (in.size().width + 2) * in.pixel();
  Multiply* const multiply = multiplier(Precision::fp32, true).multiply;
  const auto run = [&](const PackedLinear& layer, const float* first, const float* second, float* c,
                       const float* add) {
    Product product = product_of(layer);
    product.a = reinterpret_cast<const std::byte*>(first);
    product.a_stride = 2 * in.pixel_bytes();
    if (second != nullptr) {
      product.runs = 2;
      product.words /= 2;
      product.run_step = reinterpret_cast<std::uintptr_t>(second) - reinterpret_cast<std::uintptr_t>(first);
    }
    product.add = add;
    product.add_stride = product.c_stride = to.stride;
    product.relu = add != nullptr;
    product.c = c;
    multiply(width, padded(layer.out) / kPanel, product);
  };
  float* const difference = differences_.data();
  if (y % 2 == 0) {
    run(pairs.shared, line(2), nullptr, shared_.data(), nullptr);
    subtract(numbers, line(0), line(2), difference);
    run(pairs.upper, difference, line(1), to.first, shared_.data());
  } else {
    subtract(numbers, line(2), line(4), difference);
    run(pairs.lower, line(3), difference, to.first, shared_.data());
  }
}

void convolve(const PackedConvolution& layer, const FeatureMaps& in, std::size_t first_in, FeatureMaps& out,
              std::size_t first_out, std::size_t count, ConvolutionMemory& memory) {
  const auto [height, width, channels] = out.size();
  assert(out.size() == convolved(in.size(), layer.stride, layer.product.out));
  assert(in.pixel() == layer.in_pixel && out.pixel() == padded(channels));
  assert(in.precision() == layer.product.precision && out.precision() == layer.product.precision);
  Multiply* const multiply = multiplier(layer.product.precision, true).multiply;
  const std::size_t panels = padded(channels) / kPanel, stride = layer.stride, pixel = in.pixel_bytes();
  Product product = product_of(layer.product);
  product.relu = true;
  product.c_stride = out.pixel();
  product.row_scale = memory.row_scales_.data();

  if (width >= kDirectWidth) {
    // A window's lines lie where they are: a row of the product is three pieces of the map.
    product.words /= kSide;
    product.runs = kSide;
    product.run_step = in.line_bytes();
    product.a_stride = stride * pixel;
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t map = first_in + i;
      std::fill_n(memory.row_scales_.data(), width, in.scales()[map]);
      fill_map(out, first_out + i, memory.answers_.data(), [&](std::size_t y, float* to) {
        if (layer.pairs && y / 2 * 2 + 1 < height)
          return memory.convolve_paired(*layer.pairs, in, map, y, {to, out.pixel()}, width);
        product.a = in.at(map, y * stride, 0);
        product.c = to;
        multiply(width, panels, product);
      });
    }
    return;
  }

  product.a = memory.rows_.data();
  product.a_stride = gathered_stride(in);
  product.c = memory.row_answers_.data();
  std::size_t rows = 0;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t y = 0; y < height; ++y)
      for (std::size_t x = 0; x < width; ++x, ++rows) {
        for (std::size_t line = 0; line < kSide; ++line)
          std::memcpy(memory.rows_.data() + rows * product.a_stride + line * kSide * pixel,
                      in.at(first_in + i, y * stride + line, x * stride), kSide * pixel);
        memory.row_scales_[rows] = in.scales()[first_in + i];
      }
  multiply(rows, panels, product);
  const float* answer = memory.row_answers_.data();
  for (std::size_t i = 0; i < count; ++i)
    fill_map(out, first_out + i, memory.answers_.data(), [&](std::size_t, float* to) {
      std::copy_n(answer, width * out.pixel(), to);
      answer += width * out.pixel();
    });
}

void convolve_picture(const PictureConvolution& layer, const float* picture, std::size_t line,
                      FeatureMaps& out, std::size_t map, ConvolutionMemory& memory) {
  assert(out.pixel() == layer.bias.size());
  PictureLine of{.line = line,
                 .stride = layer.stride,
                 .count = out.size().width,
                 .channels = out.pixel(),
                 .weight = layer.weight.data(),
                 .bias = layer.bias.data()};
  fill_map(out, map, memory.answers_.data(), [&](std::size_t y, float* to) {
    of.x = picture + y * layer.stride * line;
    of.out = to;
    convolve_line(of);
  });
}

}  // namespace mien::model
