#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "mien/core/time.h"
#include "mien/model/features.h"

namespace mien::tracker::test {

/// Frames of sensors that turn about X, each in its own way.
inline std::vector<model::FeatureFrame> turning(std::size_t frames, std::size_t sensors = 2) {
  std::vector<model::FeatureFrame> out(frames);
  for (std::size_t f = 0; f < frames; ++f) {
    out[f].time = DeviceTime(frame_offset(static_cast<std::int64_t>(f) + 600));
    out[f].sensors.resize(sensors);
    for (std::size_t s = 0; s < sensors; ++s) {
      const double half = 0.1 * std::sin(0.2 * static_cast<double>(f) + static_cast<double>(s));
      out[f].sensors[s].rotation = {static_cast<float>(std::cos(half)), static_cast<float>(std::sin(half)), 0,
                                    0};
      out[f].sensors[s].has_rotation = true;
    }
  }
  return out;
}

}  // namespace mien::tracker::test
