#pragma once

#include <cstdint>

#include "mien/core/time.h"

namespace mien::sensor {

/// The sample times of one sensor whose packets carry none, from their arrivals and packet numbers.
class EstimatedClock {
 public:
  /// A sample that came with packet `number`. Strictly rising from call to call.
  DeviceTime add(HostTime arrival, std::uint64_t number);
  /// Another packet of the board came, with no sample of this sensor.
  void pass(std::uint64_t number);
  /// The board began anew: numbers too.
  void restart();

 private:
  DeviceTime last_ = DeviceTime::min();
};

}  // namespace mien::sensor
