#include "mien/sensor/plausibility.h"

#include <bit>
#include <cmath>

#include "mien/core/units.h"
#include "mien/sensor/sample_values.h"

namespace mien::sensor {

void Plausibility::add(HostTime arrival, const Sample& sample) {
  if (begun_ && arrival - *begun_ >= kWindow) {
    bad_ = (bad_ << 1U) | (judge() ? 0U : 1U);
    ++windows_;
    // The next begins where this one ended, so that a leap between them is seen.
    begun_ = newest_;
    begun_device_ = newest_device_;
    force_sum_m_s2_ = 0;
    forces_ = 0;
  }
  if (!begun_) {
    begun_ = arrival;
    begun_device_ = sample.time;
  }
  newest_ = arrival;
  newest_device_ = sample.time;
  if (const auto force = specific_force(sample)) {
    force_sum_m_s2_ += force->cast<double>().norm();
    ++forces_;
  }
}

bool Plausibility::judge() const {
  const double host_s = to_seconds(newest_ - *begun_);
  const double device_s = to_seconds(newest_device_ - begun_device_);
  // A window of one packet tells nothing of its clock.
  if (host_s > 0.5 * to_seconds(kWindow) && std::abs(device_s - host_s) > kClockTolerance * host_s)
    return false;
  if (forces_ == 0) return true;
  const double mean_m_s2 = force_sum_m_s2_ / forces_;
  return std::abs(mean_m_s2 - kStandardGravity_m_s2) <= kGravityTolerance * kStandardGravity_m_s2;
}

bool Plausibility::is_implausible() const {
  return std::popcount(bad_ & 0b1111U) >= 2;
}

}  // namespace mien::sensor
