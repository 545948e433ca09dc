#include "lab/peak.h"

// NEON serves the CPUs whose registers have no fixed size: such registers cannot stand in arrays.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)

// Highway compiles the part between HWY_BEFORE_NAMESPACE and HWY_AFTER_NAMESPACE once for each instruction
// set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lab/peak.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace mien::lab::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, 16>;
/// Two units of a latency of four or five need ten sums that do not wait for each other.
constexpr std::size_t kSums = 12;

/// `times` fused operations on each of twelve sums. Returns how many numbers that made: flops are twice as
/// many.
std::size_t multiply_add(std::size_t times, float* HWY_RESTRICT sums) {
  const Lanes d;
  const std::size_t lanes = hn::Lanes(d);
  hn::Vec<Lanes> held[kSums];
  HWY_UNROLL(12)
  for (std::size_t i = 0; i < kSums; ++i) held[i] = hn::LoadU(d, sums + i * lanes);
  const auto factor = hn::Set(d, 0.5F);  // Sums go to 1 and stay.
  for (std::size_t t = 0; t < times; ++t) {
    HWY_UNROLL(12)
    for (std::size_t i = 0; i < kSums; ++i) held[i] = hn::MulAdd(held[i], factor, factor);
  }
  HWY_UNROLL(12)
  for (std::size_t i = 0; i < kSums; ++i) hn::StoreU(held[i], d, sums + i * lanes);
  return times * kSums * lanes;
}

/// Reads `count` numbers, a multiple of 128, and returns something of them all.
std::uint32_t read_all(std::size_t count, const std::uint32_t* HWY_RESTRICT from) {
  const hn::CappedTag<std::uint32_t, 16> d;
  const std::size_t lanes = hn::Lanes(d);
  auto a = hn::Zero(d), b = a, c = a, e = a;
  for (std::size_t i = 0; i < count; i += 4 * lanes) {
    a = hn::Add(a, hn::LoadU(d, from + i));
    b = hn::Add(b, hn::LoadU(d, from + i + lanes));
    c = hn::Add(c, hn::LoadU(d, from + i + 2 * lanes));
    e = hn::Add(e, hn::LoadU(d, from + i + 3 * lanes));
  }
  return hn::GetLane(hn::Add(hn::Add(a, b), hn::Add(c, e)));
}

}  // namespace mien::lab::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <array>
#include <chrono>
#include <limits>

#include "mien/model/aligned.h"

namespace mien::lab {

HWY_EXPORT(multiply_add);
HWY_EXPORT(read_all);

namespace {

/// The shortest of `tries`, in seconds.
template <class Work>
double shortest(int tries, const Work& work) {
  using Clock = std::chrono::steady_clock;
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < tries; ++i) {
    const auto from = Clock::now();
    work();
    best = std::min(best, std::chrono::duration<double>(Clock::now() - from).count());
  }
  return best;
}

}  // namespace

double peak_gflops() {
  std::array<float, 12 * 16> sums;
  sums.fill(0.5F);
  std::size_t numbers = 0;
  const double seconds =
      shortest(200, [&] { numbers = HWY_DYNAMIC_DISPATCH(multiply_add)(10'000, sums.data()); });
  return 2e-9 * static_cast<double>(numbers) / seconds;
}

double read_gb_s(std::size_t bytes) {
  const std::size_t count = std::max<std::size_t>(bytes / sizeof(std::uint32_t) / 128, 1) * 128;
  const model::Aligned<std::uint32_t> numbers(count);
  volatile std::uint32_t seen = 0;  // So that reading is not left out.
  const double seconds = shortest(200, [&] { seen = HWY_DYNAMIC_DISPATCH(read_all)(count, numbers.data()); });
  return 1e-9 * static_cast<double>(count * sizeof(std::uint32_t)) / seconds;
}

}  // namespace mien::lab
#endif
