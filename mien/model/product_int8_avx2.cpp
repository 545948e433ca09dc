// Compiled for AVX2, and run only where the CPU has it. Everything here is local to this file: a function
// that other files share would be compiled for a CPU that not everybody has.
#include "mien/model/product.h"

#if defined(__x86_64__)
#include <immintrin.h>

namespace mien::model {
namespace {

#include "mien/model/tile.inc"

/// To numbers, + bias + add, relu, and into c.
void scale_and_finish(__m256i sum, const Product& p, std::size_t row, std::size_t column) {
  const __m256 scale =
      _mm256_mul_ps(_mm256_set1_ps(p.row_scale[row]), _mm256_load_ps(p.column_scale + column));
  __m256 y = _mm256_mul_ps(_mm256_cvtepi32_ps(sum), scale);
  if (p.bias != nullptr) y = _mm256_add_ps(y, _mm256_load_ps(p.bias + column));
  if (p.add != nullptr) y = _mm256_add_ps(y, _mm256_load_ps(p.add + row * p.add_stride + column));
  if (p.relu) y = _mm256_max_ps(y, _mm256_setzero_ps());
  _mm256_store_ps(p.c + row * p.c_stride + column, y);
}

/// vpmaddubsw adds two products in 16 bits and holds what is too large. An input's magnitude is at most 128
/// and a weight's 127, so two of them fit; the input's sign goes to the weight.
struct Int8 {
  struct Input {
    __m256i value, magnitude;
  };
  using Sum = __m256i;
  using Weights = __m256i;
  static constexpr std::size_t kLanes = 8;
  static constexpr std::size_t kTileRows = 4, kGroup = 1, kMostVectors = 8;
  static Sum start(const Product&, std::size_t) { return _mm256_setzero_si256(); }
  static Weights load(const std::byte* b) { return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(b)); }
  static Input broadcast(const std::byte* a) {
    const __m256i bytes = _mm256_set1_epi32(*reinterpret_cast<const int*>(a));
    const __m256i value = _mm256_xor_si256(bytes, _mm256_set1_epi8(-128));
    return {value, _mm256_abs_epi8(value)};
  }
  static Sum step(Sum sum, Weights w, const Input& x) {
    const __m256i pairs = _mm256_maddubs_epi16(x.magnitude, _mm256_sign_epi8(w, x.value));
    return _mm256_add_epi32(sum, _mm256_madd_epi16(pairs, _mm256_set1_epi16(1)));
  }
  static void finish(Sum sum, const Product& p, std::size_t row, std::size_t column) {
    scale_and_finish(sum, p, row, column);
  }
};

/// Bytes from 0 to 127 need no signs moved, and their columns are packed so that the 16 bits hold four words'
/// products: one widening for four multiplications.
struct NonnegativeInt8 {
  using Sum = __m256i;
  using Weights = __m256i;
  using Input = __m256i;
  static constexpr std::size_t kLanes = 8;
  static constexpr std::size_t kTileRows = 3, kGroup = 4, kMostVectors = 2;
  static Sum start(const Product&, std::size_t) { return _mm256_setzero_si256(); }
  static Weights load(const std::byte* b) { return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(b)); }
  static Input broadcast(const std::byte* a) { return _mm256_set1_epi32(*reinterpret_cast<const int*>(a)); }
  static Sum begin(Weights w, Input x) { return _mm256_maddubs_epi16(x, w); }
  static Sum go_on(Sum part, Weights w, Input x) {
    part = _mm256_add_epi16(part, begin(w, x));
    // g++ would add the words in pairs, for which there are not enough registers.
    __asm__("" : "+x"(part));
    return part;
  }
  static Sum end(Sum sum, Sum part) {
    return _mm256_add_epi32(sum, _mm256_madd_epi16(part, _mm256_set1_epi16(1)));
  }
  static void finish(Sum sum, const Product& p, std::size_t row, std::size_t column) {
    scale_and_finish(sum, p, row, column);
  }
};

}  // namespace

void multiply_int8_avx2(std::size_t rows, std::size_t panels, const Product& p) {
  multiply_panels<Int8>(rows, panels, p);
}

void multiply_nonnegative_avx2(std::size_t rows, std::size_t panels, const Product& p) {
  multiply_panels<NonnegativeInt8>(rows, panels, p);
}

void quantise_nonnegative_avx2(std::size_t count, float largest, const float* x, std::uint8_t* out) {
  const __m256 factor = _mm256_set1_ps(largest > 0 ? 127.0F / largest : 0.0F);
  // Packing takes the halves of registers by themselves; this puts their fours back in order.
  const __m256i order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
  std::size_t i = 0;
  for (; i + 32 <= count; i += 32) {
    __m256i four[4];
    for (std::size_t j = 0; j < 4; ++j)
      four[j] = _mm256_cvtps_epi32(_mm256_mul_ps(_mm256_loadu_ps(x + i + 8 * j), factor));
    const __m256i packed =
        _mm256_packus_epi16(_mm256_packs_epi32(four[0], four[1]), _mm256_packs_epi32(four[2], four[3]));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out + i), _mm256_permutevar8x32_epi32(packed, order));
  }
  if (i == count) return;
  const __m256i low = _mm256_cvtps_epi32(_mm256_mul_ps(_mm256_loadu_ps(x + i), factor));
  const __m256i high = _mm256_cvtps_epi32(_mm256_mul_ps(_mm256_loadu_ps(x + i + 8), factor));
  const __m256i words = _mm256_packs_epi32(low, high);
  const __m256i packed = _mm256_permutevar8x32_epi32(_mm256_packus_epi16(words, words), order);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(out + i), _mm256_castsi256_si128(packed));
}

}  // namespace mien::model
#endif
