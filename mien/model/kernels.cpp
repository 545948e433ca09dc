#include "mien/model/kernels.h"

#include "mien/model/architecture.h"

// This file is read once for each instruction set; what they share stands behind a guard.
#ifndef MIEN_MODEL_KERNELS_SHARED
#define MIEN_MODEL_KERNELS_SHARED
namespace mien::model {

/// What one product needs to know; `bias` and `add` may be null.
struct Product {
  std::size_t depth;
  const float* a;
  std::size_t a_stride;
  const float* b;
  std::size_t b_stride;
  const float* bias;
  const float* add;
  std::size_t add_stride;
  bool relu;
  float* c;
  std::size_t c_stride;
};

}  // namespace mien::model
#endif

// Highway compiles the part between HWY_BEFORE_NAMESPACE and HWY_AFTER_NAMESPACE once for each instruction
// set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mien/model/kernels.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/aligned_allocator.h>
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace mien::model::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, 16>;
using Vector = hn::Vec<Lanes>;

HWY_INLINE Vector finish(Vector sum, const Product& p, std::size_t row, std::size_t column) {
  const Lanes d;
  if (p.bias != nullptr) sum = hn::Add(sum, hn::Load(d, p.bias + column));
  if (p.add != nullptr) sum = hn::Add(sum, hn::Load(d, p.add + row * p.add_stride + column));
  return p.relu ? hn::Max(sum, hn::Zero(d)) : sum;
}

/// kRows x two vectors of the result, all sums held in registers. Every sum runs over the depth in order, so
/// that neither kRows nor the vectors' width changes the result.
template <std::size_t kRows>
HWY_INLINE void multiply_tile(const Product& p, std::size_t row, std::size_t column) {
  const Lanes d;
  const std::size_t lanes = hn::Lanes(d);
  const float* HWY_RESTRICT a = p.a + row * p.a_stride;
  const float* HWY_RESTRICT b = p.b + column;
  // Unrolled by hand over the rows: arrays of vectors of unknown size are not allowed on every target.
  Vector l0 = hn::Zero(d), l1 = l0, l2 = l0, l3 = l0, l4 = l0, l5 = l0, l6 = l0, l7 = l0;
  Vector r0 = l0, r1 = l0, r2 = l0, r3 = l0, r4 = l0, r5 = l0, r6 = l0, r7 = l0;
  for (std::size_t k = 0; k < p.depth; ++k) {
    const Vector left = hn::LoadU(d, b + k * p.b_stride);
    const Vector right = hn::LoadU(d, b + k * p.b_stride + lanes);
    const auto step = [&](std::size_t r, Vector& l_sum, Vector& r_sum) HWY_ATTR {
      const Vector x = hn::Set(d, a[r * p.a_stride + k]);
      l_sum = hn::MulAdd(x, left, l_sum);
      r_sum = hn::MulAdd(x, right, r_sum);
    };
    step(0, l0, r0);
    if constexpr (kRows > 1) step(1, l1, r1);
    if constexpr (kRows > 2) step(2, l2, r2);
    if constexpr (kRows > 3) step(3, l3, r3);
    if constexpr (kRows > 4) step(4, l4, r4);
    if constexpr (kRows > 5) step(5, l5, r5);
    if constexpr (kRows > 6) step(6, l6, r6);
    if constexpr (kRows > 7) step(7, l7, r7);
  }
  const auto store = [&](std::size_t r, Vector l_sum, Vector r_sum) HWY_ATTR {
    float* c = p.c + (row + r) * p.c_stride + column;
    hn::Store(finish(l_sum, p, row + r, column), d, c);
    hn::Store(finish(r_sum, p, row + r, column + lanes), d, c + lanes);
  };
  store(0, l0, r0);
  if constexpr (kRows > 1) store(1, l1, r1);
  if constexpr (kRows > 2) store(2, l2, r2);
  if constexpr (kRows > 3) store(3, l3, r3);
  if constexpr (kRows > 4) store(4, l4, r4);
  if constexpr (kRows > 5) store(5, l5, r5);
  if constexpr (kRows > 6) store(6, l6, r6);
  if constexpr (kRows > 7) store(7, l7, r7);
}

/// As many rows at once as the registers hold: 16 sums where there are 32 registers, 10 where there are 16.
constexpr std::size_t kTileRows =
    HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_SSSE3 ? 5 : 8;

void multiply_panel(std::size_t rows, const Product& p) {
  const std::size_t width = 2 * hn::Lanes(Lanes());
  for (std::size_t column = 0; column < kPanel; column += width) {
    std::size_t row = 0;
    for (; row + kTileRows <= rows; row += kTileRows) multiply_tile<kTileRows>(p, row, column);
    for (; row + 4 <= rows; row += 4) multiply_tile<4>(p, row, column);
    for (; row + 2 <= rows; row += 2) multiply_tile<2>(p, row, column);
    for (; row < rows; ++row) multiply_tile<1>(p, row, column);
  }
}

void multiply_panels(std::size_t rows, std::size_t panels, std::size_t b_step, const Product& first) {
  Product p = first;
  for (std::size_t i = 0; i < panels; ++i) {
    multiply_panel(rows, p);
    p.b += b_step;
    p.c += kPanel;
    if (p.bias != nullptr) p.bias += kPanel;
    if (p.add != nullptr) p.add += kPanel;
  }
}

void softmax_rows(std::size_t rows, std::size_t columns, float scale, float* x, std::size_t stride) {
  const Lanes d;
  const std::size_t lanes = hn::Lanes(d), width = padded(columns);
  const auto factor = hn::Set(d, scale);
  for (std::size_t r = 0; r < rows; ++r) {
    float* HWY_RESTRICT row = x + r * stride;
    for (std::size_t i = columns; i < width; ++i) row[i] = -1e30F;
    auto high = hn::Load(d, row);
    for (std::size_t i = lanes; i < width; i += lanes) high = hn::Max(high, hn::Load(d, row + i));
    high = hn::MaxOfLanes(d, high);
    auto sum = hn::Zero(d);
    for (std::size_t i = 0; i < width; i += lanes) {
      // Past this floor the exponential is 0 in fp32, and the padding's huge numbers cannot overflow.
      const auto e =
          hn::Exp(d, hn::Max(hn::Mul(hn::Sub(hn::Load(d, row + i), high), factor), hn::Set(d, -100.0F)));
      hn::Store(e, d, row + i);
      sum = hn::Add(sum, e);
    }
    const auto share = hn::Div(hn::Set(d, 1.0F), hn::SumOfLanes(d, sum));
    for (std::size_t i = 0; i < width; i += lanes)
      hn::Store(hn::Mul(hn::Load(d, row + i), share), d, row + i);
    for (std::size_t i = columns; i < width; ++i) row[i] = 0;
  }
}

void normalise_rows(std::size_t rows, std::size_t columns, const float* gain, const float* shift, float* x,
                    std::size_t stride) {
  const Lanes d;
  const std::size_t lanes = hn::Lanes(d);
  const auto share = hn::Set(d, 1.0F / static_cast<float>(columns));
  const auto epsilon = hn::Set(d, static_cast<float>(kLayerNormEpsilon));
  for (std::size_t r = 0; r < rows; ++r) {
    float* HWY_RESTRICT row = x + r * stride;
    auto sum = hn::Zero(d);
    for (std::size_t i = 0; i < columns; i += lanes) sum = hn::Add(sum, hn::Load(d, row + i));
    const auto mean = hn::Mul(hn::SumOfLanes(d, sum), share);
    // Two passes: the sum of squares minus the square of the sum would lose digits.
    auto squares = hn::Zero(d);
    for (std::size_t i = 0; i < columns; i += lanes) {
      const auto centred = hn::Sub(hn::Load(d, row + i), mean);
      squares = hn::MulAdd(centred, centred, squares);
    }
    const auto variance = hn::MulAdd(hn::SumOfLanes(d, squares), share, epsilon);
    const auto scale = hn::Div(hn::Set(d, 1.0F), hn::Sqrt(variance));
    for (std::size_t i = 0; i < columns; i += lanes) {
      const auto unit = hn::Mul(hn::Sub(hn::Load(d, row + i), mean), scale);
      hn::Store(hn::MulAdd(unit, hn::Load(d, gain + i), hn::Load(d, shift + i)), d, row + i);
    }
  }
}

/// 1 / (1 + e^-x). Beyond 60 either way it is 0 or 1 in fp32, and the exponential stays finite.
HWY_INLINE Vector sigmoid(Vector x) {
  const Lanes d;
  const auto held = hn::Max(hn::Min(x, hn::Set(d, 60.0F)), hn::Set(d, -60.0F));
  const auto one = hn::Set(d, 1.0F);
  return hn::Div(one, hn::Add(one, hn::Exp(d, hn::Neg(held))));
}

void apply_gates(std::size_t width, const float* HWY_RESTRICT from_input,
                 const float* HWY_RESTRICT from_state, float* HWY_RESTRICT state) {
  const Lanes d;
  for (std::size_t i = 0; i < width; i += hn::Lanes(d)) {
    const auto reset = sigmoid(hn::Add(hn::Load(d, from_input + i), hn::Load(d, from_state + i)));
    const auto keep =
        sigmoid(hn::Add(hn::Load(d, from_input + width + i), hn::Load(d, from_state + width + i)));
    const auto fresh = hn::Tanh(d, hn::MulAdd(reset, hn::Load(d, from_state + 2 * width + i),
                                              hn::Load(d, from_input + 2 * width + i)));
    hn::Store(hn::MulAdd(keep, hn::Sub(hn::Load(d, state + i), fresh), fresh), d, state + i);
  }
}

const char* name() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace mien::model::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cassert>

namespace mien::model {

HWY_EXPORT(multiply_panels);
HWY_EXPORT(softmax_rows);
HWY_EXPORT(normalise_rows);
HWY_EXPORT(apply_gates);
HWY_EXPORT(name);

AlignedFloats::AlignedFloats(std::size_t size)
    : values_(static_cast<float*>(
          hwy::AllocateAlignedBytes(std::max<std::size_t>(size, 1) * sizeof(float), nullptr, nullptr))),
      size_(size) {
  std::fill_n(values_.get(), size, 0.0F);
}

void AlignedFloats::Free::operator()(float* p) const {
  hwy::FreeAlignedBytes(p, nullptr, nullptr);
}

PackedLinear pack_linear(std::span<const float> weight, std::span<const float> bias, std::size_t out,
                         std::size_t total_in, std::size_t first, std::size_t count) {
  assert(weight.size() == out * total_in && first + count <= total_in &&
         (bias.empty() || bias.size() == out));
  PackedLinear packed{.in = count,
                      .out = out,
                      .weights = AlignedFloats(padded(out) * count),
                      .bias = AlignedFloats(padded(out))};
  for (std::size_t o = 0; o < out; ++o)
    for (std::size_t i = 0; i < count; ++i)
      packed.weights[(o / kPanel * count + i) * kPanel + o % kPanel] = weight[o * total_in + first + i];
  std::copy(bias.begin(), bias.end(), packed.bias.data());
  return packed;
}

void apply_linear(const PackedLinear& layer, std::size_t rows, const float* x, std::size_t x_stride,
                  const float* add, std::size_t add_stride, Activation activation, float* y,
                  std::size_t y_stride) {
  const Product product{.depth = layer.in,
                        .a = x,
                        .a_stride = x_stride,
                        .b = layer.weights.data(),
                        .b_stride = kPanel,
                        .bias = layer.bias.data(),
                        .add = add,
                        .add_stride = add_stride,
                        .relu = activation == Activation::relu,
                        .c = y,
                        .c_stride = y_stride};
  HWY_DYNAMIC_DISPATCH(multiply_panels)(rows, padded(layer.out) / kPanel, layer.in * kPanel, product);
}

void multiply(std::size_t rows, std::size_t depth, std::size_t columns, const float* a, std::size_t a_stride,
              const float* b, std::size_t b_stride, float* c, std::size_t c_stride) {
  const Product product{.depth = depth,
                        .a = a,
                        .a_stride = a_stride,
                        .b = b,
                        .b_stride = b_stride,
                        .bias = nullptr,
                        .add = nullptr,
                        .add_stride = 0,
                        .relu = false,
                        .c = c,
                        .c_stride = c_stride};
  HWY_DYNAMIC_DISPATCH(multiply_panels)(rows, padded(columns) / kPanel, kPanel, product);
}

void softmax_rows(std::size_t rows, std::size_t columns, float scale, float* x, std::size_t stride) {
  HWY_DYNAMIC_DISPATCH(softmax_rows)(rows, columns, scale, x, stride);
}

void normalise_rows(std::size_t rows, std::size_t columns, const float* gain, const float* shift, float* x,
                    std::size_t stride) {
  HWY_DYNAMIC_DISPATCH(normalise_rows)(rows, columns, gain, shift, x, stride);
}

void apply_gates(std::size_t width, const float* from_input, const float* from_state, float* state) {
  HWY_DYNAMIC_DISPATCH(apply_gates)(width, from_input, from_state, state);
}

std::string_view kernel_name() {
  return HWY_DYNAMIC_DISPATCH(name)();
}

std::vector<std::string_view> available_kernels() {
  std::vector<std::string_view> names;
  for (std::int64_t left = hwy::SupportedTargets() & HWY_TARGETS; left != 0; left &= left - 1)
    names.emplace_back(hwy::TargetName(left & -left));  // The lowest bit is the best target.
  return names;
}

void force_kernel(std::string_view name) {
  hwy::SetSupportedTargetsForTest(0);
  for (std::int64_t left = name.empty() ? 0 : hwy::SupportedTargets() & HWY_TARGETS; left != 0;
       left &= left - 1)
    if (hwy::TargetName(left & -left) == name) {
      hwy::SetSupportedTargetsForTest(left & -left);
      break;
    }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace mien::model
#endif
