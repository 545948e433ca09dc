#include "mien/model/picture_line.h"

#include "mien/model/kernels.h"

// NEON serves the CPUs whose registers have no fixed size, as in product.cpp.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)

// Highway compiles the part between HWY_BEFORE_NAMESPACE and HWY_AFTER_NAMESPACE once for each instruction
// set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mien/model/picture_line.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace mien::model::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, kPictureChannels>;
using Vector = hn::Vec<Lanes>;

constexpr std::size_t kLanes = hn::MaxLanes(Lanes());
constexpr std::size_t kVectors = kPictureChannels / kLanes;
/// Twelve sums: as many as leave room for a row of weights and an input.
constexpr std::size_t kMostPixels = kVectors < 12 ? 12 / kVectors : 1;

/// kPixels pixels of kPictureChannels channels, from `channel` on.
template <std::size_t kPixels>
HWY_INLINE void convolve_pixels(const PictureLine& p, std::size_t pixel, std::size_t channel) {
  const Lanes d;
  Vector sums[kPixels][kVectors];
  for (std::size_t v = 0; v < kVectors; ++v)
    for (std::size_t i = 0; i < kPixels; ++i) sums[i][v] = hn::Load(d, p.bias + channel + v * kLanes);
  for (std::size_t ky = 0; ky < 3; ++ky)
    for (std::size_t kx = 0; kx < 3; ++kx) {
      const float* from = p.x + ky * p.line + pixel * p.stride + kx;
      const float* weight = p.weight + (3 * ky + kx) * p.channels + channel;
      for (std::size_t i = 0; i < kPixels; ++i) {
        const auto x = hn::Set(d, from[i * p.stride]);
        for (std::size_t v = 0; v < kVectors; ++v)
          sums[i][v] = hn::MulAdd(hn::Load(d, weight + v * kLanes), x, sums[i][v]);
      }
    }
  for (std::size_t i = 0; i < kPixels; ++i)
    for (std::size_t v = 0; v < kVectors; ++v)
      hn::Store(hn::Max(sums[i][v], hn::Zero(d)), d, p.out + (pixel + i) * p.channels + channel + v * kLanes);
}

void convolve_line(const PictureLine& p) {
  for (std::size_t channel = 0; channel < p.channels; channel += kPictureChannels) {
    std::size_t pixel = 0;
    for (; pixel + kMostPixels <= p.count; pixel += kMostPixels)
      convolve_pixels<kMostPixels>(p, pixel, channel);
    for (; pixel < p.count; ++pixel) convolve_pixels<1>(p, pixel, channel);
  }
}

}  // namespace mien::model::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace mien::model {

HWY_EXPORT(convolve_line);

void convolve_line(const PictureLine& line) {
  HWY_DYNAMIC_DISPATCH(convolve_line)(line);
}

}  // namespace mien::model
#endif
