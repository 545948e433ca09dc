#include "mien/model/linear.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

#include "mien/model/product.h"

namespace mien::model {
namespace {

/// Where number i of column o stands, in bytes.
std::size_t place(const PackedLinear& layer, std::size_t o, std::size_t i) {
  const std::size_t numbers = numbers_in_word(layer.precision), word = i / numbers;
  return ((o / kPanel * layer.words + word) * kPanel + o % kPanel) * kWordBytes +
         i % numbers * (kWordBytes / numbers);
}

/// The largest sum of weights of one sign, among those whose products with non-negative inputs one lane of 16
/// bits adds: a half of each word of a group.
float largest_group(std::span<const float> column) {
  constexpr std::size_t kNumbers = numbers_in_word(Precision::int8) * kGroupWords;
  float largest = 0;
  for (std::size_t first = 0; first < column.size(); first += kNumbers) {
    float above[2] = {}, below[2] = {};
    for (std::size_t i = first; i < std::min(first + kNumbers, column.size()); ++i) {
      above[i / 2 % 2] += std::max(column[i], 0.0F);
      below[i / 2 % 2] += std::max(-column[i], 0.0F);
    }
    largest = std::max({largest, above[0], above[1], below[0], below[1]});
  }
  return largest;
}

/// One column's numbers as bytes, the largest +-127. Of non-negative inputs less where a group's sum would
/// not fit: 127 times 258 does, of which rounding takes up to 4.
void pack_bytes(std::span<const float> column, std::size_t o, PackedLinear& layer) {
  float largest = 0;
  for (const float w : column) largest = std::max(largest, std::abs(w));
  if (layer.inputs == Inputs::nonnegative)
    largest = std::max(largest, largest_group(column) * (127.0F / 254.0F));
  layer.scale[o] = largest / 127.0F;
  std::int32_t sum = 0;
  for (std::size_t i = 0; i < column.size(); ++i) {
    const long byte = largest > 0 ? std::lrint(column[i] * (127.0F / largest)) : 0;
    layer.weights[place(layer, o, i)] = static_cast<std::byte>(byte);
    sum += static_cast<std::int32_t>(byte);
  }
  layer.start[o] = layer.inputs == Inputs::nonnegative ? 0 : -128 * sum;
}

void pack_column(std::span<const float> column, std::size_t o, PackedLinear& layer) {
  if (layer.precision == Precision::int8) return pack_bytes(column, o, layer);
  for (std::size_t i = 0; i < column.size(); ++i) {
    std::byte* to = layer.weights.data() + place(layer, o, i);
    if (layer.precision == Precision::fp32) std::memcpy(to, &column[i], sizeof(float));
    if (layer.precision == Precision::bf16) {
      std::uint16_t rounded[16];
      round_row(1, &column[i], rounded);
      std::memcpy(to, rounded, sizeof rounded[0]);
    }
  }
}

/// The rows as the layer's precision reads them.
void convert(const PackedLinear& layer, std::size_t rows, RowsIn x, ConvertedRows& memory) {
  assert(layer.words * kWordBytes <= memory.stride && rows <= memory.scale.size());
  for (std::size_t r = 0; r < rows; ++r) {
    const float* from = x.first + r * x.stride;
    std::byte* to = memory.words.data() + r * memory.stride;
    if (layer.precision == Precision::bf16)
      round_row(layer.in, from, reinterpret_cast<std::uint16_t*>(to));
    else
      memory.scale[r] = quantise_row(layer.in, from, reinterpret_cast<std::uint8_t*>(to));
  }
}

}  // namespace

PackedLinear pack_linear(std::span<const float> weight, std::span<const float> bias, std::size_t out,
                         std::size_t total_in, std::size_t first, std::size_t count, Precision precision,
                         Inputs inputs) {
  assert(weight.size() == out * total_in && first + count <= total_in &&
         (bias.empty() || bias.size() == out));
  const std::size_t numbers = numbers_in_word(precision);
  PackedLinear packed{.precision = precision,
                      .inputs = inputs,
                      .in = count,
                      .out = out,
                      .words = (count + numbers - 1) / numbers};
  packed.weights = Aligned<std::byte>(padded(out) * packed.words * kWordBytes);
  packed.bias = AlignedFloats(padded(out));
  if (precision == Precision::int8) {
    packed.scale = AlignedFloats(padded(out));
    packed.start = Aligned<std::int32_t>(padded(out));
  }
  for (std::size_t o = 0; o < out; ++o) pack_column(weight.subspan(o * total_in + first, count), o, packed);
  std::ranges::copy(bias, packed.bias.data());
  return packed;
}

Product product_of(const PackedLinear& layer) {
  return {
      .words = layer.words,
      .b = layer.weights.data(),
      .b_step = kPanel * kWordBytes,
      .panel_step = layer.words * kPanel * kWordBytes,
      .bias = layer.bias.data(),
      .column_scale = layer.scale.data(),
      .column_start = layer.start.data(),
  };
}

ConvertedRows::ConvertedRows(std::size_t rows, std::size_t width)
    // A line more than bf16 takes: rows at a power of two from each other would fight for one place in the
    // cache.
    : stride(padded(width) * sizeof(std::uint16_t) + kLineBytes), words(rows * stride), scale(rows) {}

void apply_linear(const PackedLinear& layer, std::size_t rows, RowsIn x, RowsOut y, const LinearEnd& end,
                  ConvertedRows& memory) {
  const bool fp32 = layer.precision == Precision::fp32;
  assert(layer.inputs == Inputs::any);
  if (!fp32) convert(layer, rows, x, memory);
  Product product = product_of(layer);
  product.a = fp32 ? reinterpret_cast<const std::byte*>(x.first) : memory.words.data();
  product.a_stride = fp32 ? x.stride * sizeof(float) : memory.stride;
  product.add = end.add.first;
  product.add_stride = end.add.stride;
  product.relu = end.relu;
  product.c = y.first;
  product.c_stride = y.stride;
  product.row_scale = memory.scale.data();
  multiplier(layer.precision).multiply(rows, padded(layer.out) / kPanel, product);
}

void multiply(std::size_t rows, std::size_t depth, std::size_t columns, RowsIn a, RowsIn b, RowsOut c) {
  const Product product{
      .words = depth,
      .a = reinterpret_cast<const std::byte*>(a.first),
      .a_stride = a.stride * sizeof(float),
      .b = reinterpret_cast<const std::byte*>(b.first),
      .b_step = b.stride * sizeof(float),
      .panel_step = kPanel * kWordBytes,
      .c = c.first,
      .c_stride = c.stride,
  };
  multiplier(Precision::fp32).multiply(rows, padded(columns) / kPanel, product);
}

std::string kernel_name(Precision precision) {
  std::string name(kernel_name());
  if (precision == Precision::fp32) return name;
  name.append(" ").append(precision_name(precision));
  const std::string_view instruction = multiplier(precision).instruction;
  if (!instruction.empty()) name.append(" ").append(instruction);
  return name;
}

}  // namespace mien::model
