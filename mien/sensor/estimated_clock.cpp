#include "mien/sensor/estimated_clock.h"

#include <algorithm>

namespace mien::sensor {

DeviceTime EstimatedClock::add(HostTime arrival, std::uint64_t) {
  const DeviceTime t(arrival.time_since_epoch());
  last_ = last_ == DeviceTime::min() ? t : std::max(t, last_ + Duration(1000));
  return last_;
}
void EstimatedClock::pass(std::uint64_t) {}
void EstimatedClock::restart() {}

}  // namespace mien::sensor
