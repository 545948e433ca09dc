#pragma once

#include <optional>

#include "mien/core/sliding_median.h"
#include "mien/core/time.h"
#include "mien/eyewear/block_median.h"
#include "mien/sensor/sample.h"

namespace mien::eyewear {

/// What one photo-reflective sensor's own LED gave back, without ambient light and without the strobes of
/// motion capture cameras: the median of the last ten differences between LED on and LED off. Ambient light
/// is in both, and lamps change little between them; a strobe falls into one of the two, brightens it, and
/// does so in fewer than half of ten samples. It answers 4.5 samples late: 18 ms at 250 Hz. A pure function
/// of the calls. No allocation.
class AmbientFilter {
 public:
  /// After a longer pause the samples before it do not count: the face has moved on.
  static constexpr Duration kForget = std::chrono::milliseconds(200);

  /// A photo_reflective sample, in the order of device times. Returns the reflected light as a share of full
  /// scale, -1 to 1; below 0 only by noise. One that is not newer than the last (doubled, overtaken) changes
  /// nothing, unless it is by more than kForget: then the device began anew.
  double add(const sensor::Sample& sample);
  /// Nothing that was heard before counts any more.
  void reset();

 private:
  SlidingMedian<kMedianSamples> median_;
  std::optional<DeviceTime> newest_;
};

}  // namespace mien::eyewear
