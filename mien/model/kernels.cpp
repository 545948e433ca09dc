#include "mien/model/kernels.h"

#include "mien/model/architecture.h"

// NEON serves CPUs with SVE too, as in product.cpp, so that kernel_name() tells what ran in both.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)

// Highway compiles the part between HWY_BEFORE_NAMESPACE and HWY_AFTER_NAMESPACE once for each instruction
// set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mien/model/kernels.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace mien::model::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, 16>;
using Vector = hn::Vec<Lanes>;

/// 2^x for x from -126 to 0, to 2e-7 of itself: the whole part goes into the exponent, and of the rest, half
/// at most either way, the series of e^(x ln 2) to its sixth power is taken.
HWY_INLINE Vector exp2(Vector x) {
  const Lanes d;
  const hn::RebindToSigned<Lanes> integers;
  const auto whole = hn::Round(x), rest = hn::Sub(x, whole);
  auto series = hn::Set(d, 1.54035304e-4F);
  for (const float of :
       {1.33335581e-3F, 9.61812911e-3F, 5.55041087e-2F, 2.40226507e-1F, 6.93147181e-1F, 1.0F})
    series = hn::MulAdd(series, rest, hn::Set(d, of));
  const auto exponent = hn::ShiftLeft<23>(hn::ConvertTo(integers, whole));
  return hn::BitCast(d, hn::Add(hn::BitCast(integers, series), exponent));
}

void softmax_rows(std::size_t rows, std::size_t columns, float scale, float* x, std::size_t stride) {
  constexpr float kLog2E = 1.44269504F;
  const Lanes d;
  const std::size_t lanes = hn::Lanes(d), width = padded(columns);
  const auto factor = hn::Set(d, scale * kLog2E);
  for (std::size_t r = 0; r < rows; ++r) {
    float* HWY_RESTRICT row = x + r * stride;
    for (std::size_t i = columns; i < width; ++i) row[i] = -1e30F;
    auto high = hn::Load(d, row);
    for (std::size_t i = lanes; i < width; i += lanes) high = hn::Max(high, hn::Load(d, row + i));
    high = hn::MaxOfLanes(d, high);
    auto sum = hn::Zero(d);
    for (std::size_t i = 0; i < width; i += lanes) {
      const auto lower = hn::Mul(hn::Sub(hn::Load(d, row + i), high), factor);
      // What is smaller than any share that counts, and the padding's huge numbers, stay within 2^x's range.
      const auto e = exp2(hn::Max(lower, hn::Set(d, -126.0F)));
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
namespace mien::model {

HWY_EXPORT(softmax_rows);
HWY_EXPORT(normalise_rows);
HWY_EXPORT(apply_gates);
HWY_EXPORT(name);

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
