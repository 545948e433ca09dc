// Compiled for AVX-512 with its bf16 extension, and run only where the CPU has it. Everything here is local
// to this file: a function that other files share would be compiled for a CPU that not everybody has.
#include "mien/model/product.h"

#if defined(__x86_64__)
#include <immintrin.h>

namespace mien::model {
namespace {

#include "mien/model/tile.inc"

struct Bf16 {
  using Sum = __m512;
  using Weights = __m512bh;
  using Input = __m512bh;
  static constexpr std::size_t kLanes = 16;
  static constexpr std::size_t kTileRows = 12, kGroup = 1, kMostVectors = 8;
  static Sum start(const Product&, std::size_t) { return _mm512_setzero_ps(); }
  static Weights load(const std::byte* b) { return (__m512bh)_mm512_loadu_si512(b); }
  static Input broadcast(const std::byte* a) {
    return (__m512bh)_mm512_set1_epi32(*reinterpret_cast<const int*>(a));
  }
  static Sum step(Sum sum, Weights w, Input x) { return _mm512_dpbf16_ps(sum, w, x); }
  static void finish(Sum sum, const Product& p, std::size_t row, std::size_t column) {
    if (p.bias != nullptr) sum = _mm512_add_ps(sum, _mm512_load_ps(p.bias + column));
    if (p.add != nullptr) sum = _mm512_add_ps(sum, _mm512_load_ps(p.add + row * p.add_stride + column));
    if (p.relu) sum = _mm512_max_ps(sum, _mm512_setzero_ps());
    _mm512_store_ps(p.c + row * p.c_stride + column, sum);
  }
};

}  // namespace

void multiply_bf16_avx512(std::size_t rows, std::size_t panels, const Product& p) {
  multiply_panels<Bf16>(rows, panels, p);
}

}  // namespace mien::model
#endif
