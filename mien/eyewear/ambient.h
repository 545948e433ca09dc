#pragma once

#include <cstddef>
#include <optional>

#include "mien/core/sliding_median.h"
#include "mien/core/time.h"
#include "mien/sensor/sample.h"

namespace mien::eyewear {

/// Length of the published system's median filter, in samples: flashes that hit fewer than half of them
/// (motion capture's strobes) leave no trace.
inline constexpr std::size_t kMedianSamples = 10;

/// Decimating median: one value for every ten consecutive ones (a sensor of 230 Hz gives 23 Hz), the mean of
/// the middle two. No allocation.
class BlockMedian {
 public:
  /// The median where `value` completes a block of ten; none otherwise.
  std::optional<float> add(float value) {
    const double median = median_.add(double{value});
    if (median_.count() < kMedianSamples) return std::nullopt;
    median_.reset();
    return static_cast<float>(median);
  }
  /// Drops an unfinished block, as after a gap.
  void reset() { median_.reset(); }

 private:
  SlidingMedian<kMedianSamples> median_;
};

/// Ambient light rejection for one photo-reflective sensor: the sliding median of the last ten differences
/// LED on less LED off. The difference cancels ambient light, which hardly changes between the two; the
/// median rejects strobes of motion capture cameras, which hit fewer than half of ten samples. Delay: 4.5
/// samples, 18 ms at 250 Hz. A pure function of the calls. No allocation. Source: Asano et al. 2017
/// (docs/method/eyewear.md).
class AmbientFilter {
 public:
  /// After a pause longer than this the earlier samples are dropped.
  static constexpr Duration kForget = std::chrono::milliseconds(200);

  /// An eyewear_light sample, in the order of device times. Returns the reflected light as a share of full
  /// scale, -1 to 1; below 0 only by noise. A sample not newer than the last (doubled, out of order) changes
  /// nothing, unless it is older by more than kForget: then the device restarted.
  double add(const sensor::Sample& sample);
  /// Drops all samples.
  void reset();

 private:
  SlidingMedian<kMedianSamples> median_;
  std::optional<DeviceTime> newest_;
};

}  // namespace mien::eyewear
