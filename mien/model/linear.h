#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "mien/model/aligned.h"
#include "mien/model/kernels.h"
#include "mien/model/precision.h"

/// The networks' linear layers in three precisions. Weights are laid out once; a call allocates nothing, runs
/// on one thread, and gives the same bits each time on one build and CPU family. A row computed among others
/// equals the row computed alone, to the bit, in every precision.
namespace mien::model {

/// Numbers in one 32-bit word: 1, 2 or 4.
[[nodiscard]] constexpr std::size_t numbers_in_word(Precision precision) {
  return precision == Precision::fp32 ? 1 : precision == Precision::bf16 ? 2 : 4;
}

/// What is known of a layer's inputs: after a ReLU they are not negative, and int8 then takes them as bytes
/// from 0 to 127.
enum class Inputs { any, nonnegative };

/// Of non-negative inputs int8 adds the products of this many words in 16 bits. Columns are packed so that
/// they fit.
inline constexpr std::size_t kGroupWords = 4;

/// A linear layer y = W x + b, laid out so that each call reads its weights in order.
struct PackedLinear {
  Precision precision = Precision::fp32;
  Inputs inputs = Inputs::any;
  std::size_t in = 0, out = 0;
  std::size_t words = 0;        ///< `in` in words, rounded up; zeros behind the end.
  Aligned<std::byte> weights;   ///< padded(out) / kPanel panels of words x kPanel words.
  AlignedFloats bias;           ///< padded(out); zeros behind the end.
  AlignedFloats scale;          ///< int8: padded(out), what a weight's byte counts.
  Aligned<std::int32_t> start;  ///< int8: padded(out), -128 times the sum of a column's bytes, or 0.
};

/// Packs columns [first, first + count) of the [out, total_in] matrix `weight`; an empty bias is zero.
[[nodiscard]] PackedLinear pack_linear(std::span<const float> weight, std::span<const float> bias,
                                       std::size_t out, std::size_t total_in, std::size_t first,
                                       std::size_t count, Precision precision, Inputs inputs = Inputs::any);

/// Memory in which rows are put into a layer's precision: for up to `rows` of up to `width` numbers.
struct ConvertedRows {
  ConvertedRows() = default;
  ConvertedRows(std::size_t rows, std::size_t width);
  std::size_t stride = 0;  ///< Bytes.
  Aligned<std::byte> words;
  AlignedFloats scale;
};

/// Rows of numbers, the first of which stands there; `stride` numbers from row to row.
struct RowsIn {
  const float* first = nullptr;
  std::size_t stride = 0;
};
struct RowsOut {
  float* first = nullptr;
  std::size_t stride = 0;
};

/// What happens to W x + b: `add` is added, which may be nothing or the output itself; then relu.
struct LinearEnd {
  RowsIn add;
  bool relu = false;
};

/// y[r] = end(W x[r] + b) for each of `rows` rows. y has padded(out) columns, of which those behind `out`
/// become 0 (plus add); it and `add` are 64-byte aligned with strides of whole 64 bytes. `memory` has room
/// for the rows, and is left alone in fp32. Numbers that are not finite spoil their row.
void apply_linear(const PackedLinear& layer, std::size_t rows, RowsIn x, RowsOut y, const LinearEnd& end,
                  ConvertedRows& memory);

/// c = a b for a [rows x depth] and b [depth x padded columns], fp32: attention's two products.
void multiply(std::size_t rows, std::size_t depth, std::size_t columns, RowsIn a, RowsIn b, RowsOut c);

/// The variant that this CPU runs in a precision: fp32's is kernel_name(); the others say themselves behind
/// it, and the instruction that they use where it is not one of Highway's: "AVX3 bf16 vdpbf16ps".
[[nodiscard]] std::string kernel_name(Precision precision);

}  // namespace mien::model
