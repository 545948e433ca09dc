#include "mien/model/product.h"

#include "mien/model/kernels.h"

// NEON serves the CPUs whose registers have no fixed size: such registers cannot stand in arrays.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)

// Highway compiles the part between HWY_BEFORE_NAMESPACE and HWY_AFTER_NAMESPACE once for each instruction
// set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mien/model/product.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace mien::model::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, 16>;
using Vector = hn::Vec<Lanes>;
using Words = hn::RebindToUnsigned<Lanes>;
using Integers = hn::RebindToSigned<Lanes>;

#include "mien/model/tile.inc"

/// + bias + add, relu, and into c.
HWY_INLINE void finish(Vector sum, const Product& p, std::size_t row, std::size_t column) {
  const Lanes d;
  if (p.bias != nullptr) sum = hn::Add(sum, hn::Load(d, p.bias + column));
  if (p.add != nullptr) sum = hn::Add(sum, hn::Load(d, p.add + row * p.add_stride + column));
  hn::Store(p.relu ? hn::Max(sum, hn::Zero(d)) : sum, d, p.c + row * p.c_stride + column);
}

struct Fp32 {
  using Sum = Vector;
  using Weights = Vector;
  using Input = Vector;
  static constexpr std::size_t kLanes = hn::MaxLanes(Lanes());
  static constexpr std::size_t kGroup = 1, kMostVectors = 8;
  /// As many as leave room for the weights and an input: 24 sums where there are 32 registers, 12 where 16.
  static constexpr std::size_t kTileRows = HWY_TARGET <= HWY_AVX3 || HWY_TARGET == HWY_NEON ? 12 : 6;
  static HWY_INLINE Sum start(const Product&, std::size_t) { return hn::Zero(Lanes()); }
  static HWY_INLINE Weights load(const std::byte* b) {
    return hn::LoadU(Lanes(), reinterpret_cast<const float*>(b));
  }
  static HWY_INLINE Input broadcast(const std::byte* a) {
    return hn::Set(Lanes(), *reinterpret_cast<const float*>(a));
  }
  static HWY_INLINE Sum step(Sum sum, Weights w, Input x) { return hn::MulAdd(w, x, sum); }
  static HWY_INLINE void finish(Sum sum, const Product& p, std::size_t row, std::size_t column) {
    HWY_NAMESPACE::finish(sum, p, row, column);
  }
};

/// A word of the other precisions, as it stands in memory.
struct WordStep {
  using Weights = hn::Vec<Words>;
  using Input = Weights;
  static constexpr std::size_t kLanes = hn::MaxLanes(Lanes());
  static constexpr std::size_t kTileRows = 4, kGroup = 1, kMostVectors = 8;
  static HWY_INLINE Weights load(const std::byte* b) {
    return hn::LoadU(Words(), reinterpret_cast<const std::uint32_t*>(b));
  }
  static HWY_INLINE Input broadcast(const std::byte* a) {
    return hn::Set(Words(), *reinterpret_cast<const std::uint32_t*>(a));
  }
};

/// A bf16 number is the upper half of an fp32 one. The second of a word is added first, as vdpbf16ps does.
struct Bf16 : WordStep {
  using Sum = Vector;
  static HWY_INLINE Sum start(const Product&, std::size_t) { return hn::Zero(Lanes()); }
  static HWY_INLINE Vector first(Weights w) { return hn::BitCast(Lanes(), hn::ShiftLeft<16>(w)); }
  static HWY_INLINE Vector second(Weights w) {
    return hn::BitCast(Lanes(), hn::And(w, hn::Set(Words(), 0xffff0000U)));
  }
  static HWY_INLINE Sum step(Sum sum, Weights w, Input x) {
    return hn::MulAdd(first(w), first(x), hn::MulAdd(second(w), second(x), sum));
  }
  static HWY_INLINE void finish(Sum sum, const Product& p, std::size_t row, std::size_t column) {
    HWY_NAMESPACE::finish(sum, p, row, column);
  }
};

/// Bytes of inputs are 0 to 255 and stand for -128 to 127, so that the instructions that multiply unsigned
/// bytes by signed ones can have them; the sums begin at what that adds.
struct Int8 : WordStep {
  using Sum = hn::Vec<Integers>;
  static HWY_INLINE Sum start(const Product& p, std::size_t column) {
    return hn::Load(Integers(), p.column_start + column);
  }
  template <int kByte>
  static HWY_INLINE Sum add(Sum sum, Weights w, Input x) {
    const auto weight = hn::ShiftRight<24>(hn::BitCast(Integers(), hn::ShiftLeft<24 - 8 * kByte>(w)));
    const auto input = hn::ShiftRight<24>(hn::ShiftLeft<24 - 8 * kByte>(x));
    return hn::Add(sum, hn::Mul(weight, hn::BitCast(Integers(), input)));
  }
  static HWY_INLINE Sum step(Sum sum, Weights w, Input x) {
    return add<3>(add<2>(add<1>(add<0>(sum, w, x), w, x), w, x), w, x);
  }
  static HWY_INLINE void finish(Sum sum, const Product& p, std::size_t row, std::size_t column) {
    const Lanes d;
    const auto scale = hn::Mul(hn::Set(d, p.row_scale[row]), hn::Load(d, p.column_scale + column));
    HWY_NAMESPACE::finish(hn::Mul(hn::ConvertTo(d, sum), scale), p, row, column);
  }
};

void multiply_fp32(std::size_t rows, std::size_t panels, const Product& p) {
  multiply_panels<Fp32>(rows, panels, p);
}

void multiply_bf16(std::size_t rows, std::size_t panels, const Product& p) {
  multiply_panels<Bf16>(rows, panels, p);
}

void multiply_int8(std::size_t rows, std::size_t panels, const Product& p) {
  multiply_panels<Int8>(rows, panels, p);
}

/// Rounded to the nearest, halves to even.
void round_row(std::size_t count, const float* x, std::uint16_t* out) {
  const Words d;
  const hn::Rebind<std::uint16_t, Words> half;
  const auto round = [&](const float* from, std::uint16_t* to) HWY_ATTR {
    const auto bits = hn::LoadU(d, reinterpret_cast<const std::uint32_t*>(from));
    const auto odd = hn::And(hn::ShiftRight<16>(bits), hn::Set(d, 1));
    const auto rounded = hn::ShiftRight<16>(hn::Add(hn::Add(bits, odd), hn::Set(d, 0x7fff)));
    hn::StoreU(hn::DemoteTo(half, hn::BitCast(Integers(), rounded)), half, to);
  };
  std::size_t i = 0;
  for (; i + Fp32::kLanes <= count; i += Fp32::kLanes) round(x + i, out + i);
  if (i == count) return;
  float rest[Fp32::kLanes] = {};
  for (std::size_t j = i; j < count; ++j) rest[j - i] = x[j];
  round(rest, out + i);
}

/// The largest number becomes +-127.
float quantise_row(std::size_t count, const float* x, std::uint8_t* out) {
  const Lanes d;
  const hn::Rebind<std::uint8_t, Lanes> bytes;
  const std::size_t whole = count / Fp32::kLanes * Fp32::kLanes;
  float rest[Fp32::kLanes] = {};
  for (std::size_t i = whole; i < count; ++i) rest[i - whole] = x[i];
  auto high = hn::Abs(hn::LoadU(d, rest));
  for (std::size_t i = 0; i < whole; i += Fp32::kLanes) high = hn::Max(high, hn::Abs(hn::LoadU(d, x + i)));
  const float largest = hn::GetLane(hn::MaxOfLanes(d, high));
  const auto factor = hn::Set(d, largest > 0 ? 127.0F / largest : 0.0F);
  const auto round = [&](const float* from, std::uint8_t* to) HWY_ATTR {
    const auto nearest = hn::NearestInt(hn::Mul(hn::LoadU(d, from), factor));
    hn::StoreU(hn::DemoteTo(bytes, hn::Add(nearest, hn::Set(Integers(), 128))), bytes, to);
  };
  for (std::size_t i = 0; i < whole; i += Fp32::kLanes) round(x + i, out + i);
  if (whole < count) round(rest, out + whole);
  return largest / 127.0F;
}

void subtract(std::size_t count, const float* a, const float* b, float* HWY_RESTRICT out) {
  const Lanes d;
  for (std::size_t i = 0; i < count; i += Fp32::kLanes)
    hn::StoreU(hn::Sub(hn::LoadU(d, a + i), hn::LoadU(d, b + i)), d, out + i);
}

float largest_number(std::size_t count, const float* x) {
  const Lanes d;
  auto high = hn::Zero(d), other = high;
  constexpr std::size_t kHalf = Fp32::kLanes == 16 ? 0 : 8;  // Two, so that none waits for the other.
  for (std::size_t i = 0; i < count; i += 16)
    for (std::size_t j = 0; j < 16 - kHalf; j += Fp32::kLanes) {
      high = hn::Max(high, hn::LoadU(d, x + i + j));
      if (kHalf > 0) other = hn::Max(other, hn::LoadU(d, x + i + kHalf + j));
    }
  return hn::GetLane(hn::MaxOfLanes(d, hn::Max(high, other)));
}

void quantise_nonnegative(std::size_t count, float largest, const float* x, std::uint8_t* out) {
  const Lanes d;
  const hn::Rebind<std::uint8_t, Lanes> bytes;
  const auto factor = hn::Set(d, largest > 0 ? 127.0F / largest : 0.0F);
  for (std::size_t i = 0; i < count; i += Fp32::kLanes)
    hn::StoreU(hn::DemoteTo(bytes, hn::NearestInt(hn::Mul(hn::LoadU(d, x + i), factor))), bytes, out + i);
}

std::int64_t target() {
  return HWY_TARGET;
}

}  // namespace mien::model::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mien::model {

HWY_EXPORT(multiply_fp32);
HWY_EXPORT(multiply_bf16);
HWY_EXPORT(multiply_int8);
HWY_EXPORT(round_row);
HWY_EXPORT(quantise_row);
HWY_EXPORT(subtract);
HWY_EXPORT(largest_number);
HWY_EXPORT(quantise_nonnegative);
HWY_EXPORT(target);

Multiplier multiplier(Precision precision, [[maybe_unused]] bool nonnegative) {
#if defined(__x86_64__)
  // A forced kernel forbids what is beyond it.
  const std::int64_t target = HWY_DYNAMIC_DISPATCH(target)();
  const bool avx512 = target == HWY_AVX3 || target == HWY_AVX3_DL, avx2 = avx512 || target == HWY_AVX2;
  if (precision == Precision::bf16 && avx512 && __builtin_cpu_supports("avx512bf16"))
    return {multiply_bf16_avx512, "vdpbf16ps"};
  if (precision == Precision::int8 && avx512 && __builtin_cpu_supports("avx512vnni"))
    return {multiply_int8_avx512, "vpdpbusd"};
  if (precision == Precision::int8 && avx2)
    return {nonnegative ? multiply_nonnegative_avx2 : multiply_int8_avx2, "vpmaddubsw"};
#endif
  switch (precision) {
    case Precision::bf16:
      return {HWY_DYNAMIC_DISPATCH(multiply_bf16), ""};
    case Precision::int8:
      return {HWY_DYNAMIC_DISPATCH(multiply_int8), ""};
    case Precision::fp32:
      break;
  }
  return {HWY_DYNAMIC_DISPATCH(multiply_fp32), ""};
}

void round_row(std::size_t count, const float* x, std::uint16_t* out) {
  HWY_DYNAMIC_DISPATCH(round_row)(count, x, out);
}

float quantise_row(std::size_t count, const float* x, std::uint8_t* out) {
  return HWY_DYNAMIC_DISPATCH(quantise_row)(count, x, out);
}

void subtract(std::size_t count, const float* a, const float* b, float* out) {
  HWY_DYNAMIC_DISPATCH(subtract)(count, a, b, out);
}

float largest_number(std::size_t count, const float* x) {
  return HWY_DYNAMIC_DISPATCH(largest_number)(count, x);
}

void quantise_nonnegative(std::size_t count, float largest, const float* x, std::uint8_t* out) {
#if defined(__x86_64__)
  if (HWY_DYNAMIC_DISPATCH(target)() == HWY_AVX2) return quantise_nonnegative_avx2(count, largest, x, out);
#endif
  HWY_DYNAMIC_DISPATCH(quantise_nonnegative)(count, largest, x, out);
}

}  // namespace mien::model
#endif
