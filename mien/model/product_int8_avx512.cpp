// Compiled for AVX-512 with its VNNI extension, and run only where the CPU has it. Everything here is local
// to this file: a function that other files share would be compiled for a CPU that not everybody has.
#include "mien/model/product.h"

#if defined(__x86_64__)
#include <immintrin.h>

namespace mien::model {
namespace {

#include "mien/model/tile.inc"

struct Int8 {
  using Sum = __v16si;  // g++ 12 puts sums of the type __m512i into memory at each step.
  using Weights = __m512i;
  using Input = __m512i;
  static constexpr std::size_t kLanes = 16;
  static constexpr std::size_t kTileRows = 12, kGroup = 1, kMostVectors = 8;
  static Sum start(const Product& p, std::size_t column) {
    return (__v16si)_mm512_load_si512(p.column_start + column);
  }
  static Weights load(const std::byte* b) { return _mm512_loadu_si512(b); }
  static Input broadcast(const std::byte* a) { return _mm512_set1_epi32(*reinterpret_cast<const int*>(a)); }
  static Sum step(Sum sum, Weights w, Input x) { return (__v16si)_mm512_dpbusd_epi32((__m512i)sum, x, w); }
  static void finish(Sum sum, const Product& p, std::size_t row, std::size_t column) {
    const __m512 scale =
        _mm512_mul_ps(_mm512_set1_ps(p.row_scale[row]), _mm512_load_ps(p.column_scale + column));
    __m512 y = _mm512_mul_ps(_mm512_cvtepi32_ps((__m512i)sum), scale);
    if (p.bias != nullptr) y = _mm512_add_ps(y, _mm512_load_ps(p.bias + column));
    if (p.add != nullptr) y = _mm512_add_ps(y, _mm512_load_ps(p.add + row * p.add_stride + column));
    if (p.relu) y = _mm512_max_ps(y, _mm512_setzero_ps());
    _mm512_store_ps(p.c + row * p.c_stride + column, y);
  }
};

}  // namespace

void multiply_int8_avx512(std::size_t rows, std::size_t panels, const Product& p) {
  multiply_panels<Int8>(rows, panels, p);
}

}  // namespace mien::model
#endif
