#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "mien/model/kernels.h"
#include "mien/model/precision.h"

namespace mien::model {

struct PackedLinear;  // linear.h

inline constexpr std::size_t kWordBytes = 4;
inline constexpr std::size_t kLineBytes = 64;  ///< Of the caches.

/// c = a b, then + bias + add, then the larger of that and 0: what every kernel of the linear layers
/// computes.
///
/// Both factors are read in 32-bit *words*: one fp32 number, two bf16 or four int8. A word of `a` is that
/// many numbers of one row; `b` has at each step, for each of its columns, a word of that many numbers of
/// the column. So every precision is walked alike, and what differs is what a step does with its two words.
struct Product {
  std::size_t words = 0;  ///< Steps: of the whole sum, or of each of its runs.
  const std::byte* a = nullptr;
  std::size_t a_stride = 0;  ///< Bytes from row to row.
  /// Pieces that a row of `a` lies in, run_step bytes from one to the next, in whatever memory: a step
  /// backwards wraps around.
  std::size_t runs = 1;
  std::uintptr_t run_step = 0;
  const std::byte* b = nullptr;
  std::size_t b_step = 0;       ///< Bytes from step to step of one panel of columns.
  std::size_t panel_step = 0;   ///< Bytes from panel to panel.
  const float* bias = nullptr;  ///< One number a column; may be null.
  const float* add = nullptr;   ///< A number a row and column; may be null, may be c.
  std::size_t add_stride = 0;   ///< This and c_stride in numbers.
  bool relu = false;
  float* c = nullptr;
  std::size_t c_stride = 0;
  // int8 only: a number stands for (its byte - 128) row_scale, or its byte times column_scale; of a
  // non-negative one the byte counts as it is.
  const float* row_scale = nullptr;
  const float* column_scale = nullptr;
  const std::int32_t* column_start = nullptr;  ///< -128 times the sum of a column's bytes, or 0.
};

/// Rows x panels of a product. Every sum runs over the steps in order, so that neither the number of rows
/// nor the registers' width changes a bit of it.
using Multiply = void(std::size_t rows, std::size_t panels, const Product& product);

/// How this CPU multiplies, and the instruction by which, where that is not one of Highway's.
struct Multiplier {
  Multiply* multiply = nullptr;
  std::string_view instruction;
};
/// `nonnegative` (linear.h says of what): int8's words are then a multiple of kGroupWords.
[[nodiscard]] Multiplier multiplier(Precision precision, bool nonnegative = false);

/// The product of a packed layer, but for `a`, `c` and what is done at its end.
[[nodiscard]] Product product_of(const PackedLinear& layer);

/// `count` numbers to bf16, rounded to the nearest, halves to even; up to 15 numbers behind them become 0.
void round_row(std::size_t count, const float* x, std::uint16_t* out);
/// `count` numbers to bytes, 128 for 0 and the largest 127 away from it; up to 15 behind them become 128.
/// Returns what one step of a byte counts.
[[nodiscard]] float quantise_row(std::size_t count, const float* x, std::uint8_t* out);
/// a - b, `count` numbers, a multiple of 16.
void subtract(std::size_t count, const float* a, const float* b, float* out);
/// The largest of `count` numbers, a multiple of 16, or 0.
[[nodiscard]] float largest_number(std::size_t count, const float* x);
/// `count` numbers, a multiple of 16, from 0 to `largest`, to bytes from 0 to 127.
void quantise_nonnegative(std::size_t count, float largest, const float* x, std::uint8_t* out);

#if defined(__x86_64__)
// Beyond what Debian's Highway knows. Only for CPUs that have the instructions: multiplier() asks.

/// vdpbf16ps adds a word's second product, then its first, as the portable one does, but takes denormals for
/// 0.
Multiply multiply_bf16_avx512;
/// vpdpbusd: whole numbers, so the same bits as the portable one.
Multiply multiply_int8_avx512;
/// vpmaddubsw: the same bits again.
Multiply multiply_int8_avx2;
/// Of non-negative inputs: four words' products are added in 16 bits.
Multiply multiply_nonnegative_avx2;
void quantise_nonnegative_avx2(std::size_t count, float largest, const float* x, std::uint8_t* out);
#endif

}  // namespace mien::model
