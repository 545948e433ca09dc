#include "mien/core/resample.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <vector>

namespace mien {
namespace {

/// Zero crossings of the sinc on each side. Raising: steeper, and slower.
constexpr double kCrossings = 16;
/// Of the lower rate.
constexpr double kCutoff = 0.45;
/// Places between two samples that the kernel is made for; rates whose ratio needs more are off by a
/// thousandth of a sample.
constexpr std::uint64_t kMostPhases = 512;

/// The kernel at `phases` places between two samples, `taps` values each.
struct Kernel {
  std::size_t half = 0, taps = 0;
  std::uint64_t phases = 0;
  std::vector<float> values;
};

Kernel kernel_of(std::uint32_t from_hz, std::uint32_t to_hz) {
  Kernel kernel;
  const double cutoff = kCutoff * std::min(from_hz, to_hz) / from_hz;  // Cycles a sample.
  const double reach = kCrossings / (2 * cutoff);
  kernel.half = static_cast<std::size_t>(std::ceil(reach));
  kernel.taps = 2 * kernel.half + 1;
  kernel.phases = std::min<std::uint64_t>(kMostPhases, to_hz / std::gcd(from_hz, to_hz));
  kernel.values.resize(kernel.phases * kernel.taps);
  for (std::uint64_t phase = 0; phase < kernel.phases; ++phase) {
    const auto values = kernel.values.begin() + static_cast<std::ptrdiff_t>(phase * kernel.taps);
    double sum = 0;
    for (std::size_t tap = 0; tap < kernel.taps; ++tap) {
      const double x = static_cast<double>(tap) - static_cast<double>(kernel.half) -
                       static_cast<double>(phase) / static_cast<double>(kernel.phases);
      const double angle = std::numbers::pi * x;
      const double sinc = x == 0 ? 2 * cutoff : std::sin(2 * cutoff * angle) / angle;
      const double across = angle / reach;
      const double window =
          std::abs(x) >= reach ? 0 : 0.42 + 0.5 * std::cos(across) + 0.08 * std::cos(2 * across);
      values[static_cast<std::ptrdiff_t>(tap)] = static_cast<float>(sinc * window);
      sum += sinc * window;
    }
    for (std::size_t tap = 0; tap < kernel.taps; ++tap)
      values[static_cast<std::ptrdiff_t>(tap)] /= static_cast<float>(sum);
  }
  return kernel;
}

}  // namespace

Sound resampled(const Sound& sound, std::uint32_t rate_hz) {
  if (sound.rate_hz == rate_hz) return sound;
  Sound out{.rate_hz = rate_hz, .samples = {}};
  if (sound.rate_hz == 0 || rate_hz == 0) return out;
  const Kernel kernel = kernel_of(sound.rate_hz, rate_hz);
  const auto count = static_cast<std::int64_t>(sound.samples.size());
  const auto half = static_cast<std::int64_t>(kernel.half), taps = static_cast<std::int64_t>(kernel.taps);
  out.samples.resize(sound.samples.size() * std::uint64_t{rate_hz} / sound.rate_hz);
  for (std::size_t i = 0; i < out.samples.size(); ++i) {
    // In parts of a sample: exact.
    const std::uint64_t place = std::uint64_t{i} * sound.rate_hz;
    auto before = static_cast<std::int64_t>(place / rate_hz);
    std::uint64_t phase = ((place % rate_hz) * kernel.phases + rate_hz / 2) / rate_hz;
    if (phase == kernel.phases) phase = 0, ++before;
    const float* const values = kernel.values.data() + phase * kernel.taps;
    const std::int64_t first = before - half;
    const std::int64_t from = std::max<std::int64_t>(0, -first), to = std::min(taps, count - first);
    // Four sums, which a compiler may keep side by side.
    float sums[4] = {};
    std::int64_t tap = from;
    for (; tap + 4 <= to; tap += 4)
      for (std::int64_t lane = 0; lane < 4; ++lane)
        sums[lane] += values[tap + lane] * sound.samples[static_cast<std::size_t>(first + tap + lane)];
    for (; tap < to; ++tap) sums[0] += values[tap] * sound.samples[static_cast<std::size_t>(first + tap)];
    out.samples[i] = (sums[0] + sums[1]) + (sums[2] + sums[3]);
  }
  return out;
}

}  // namespace mien
