#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "mien/core/time.h"
#include "mien/face/output_frame.h"
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

/// What sensors on the skin answer: measured, but where the eyes look, which none of them sees.
inline std::array<face::Provenance, face::kShapeCount> felt() {
  std::array<face::Provenance, face::kShapeCount> out{};
  out.fill(face::Provenance::measured);
  for (const char* gaze : {"eyeLookDown_L", "eyeLookDown_R", "eyeLookIn_L", "eyeLookIn_R", "eyeLookOut_L",
                           "eyeLookOut_R", "eyeLookUp_L", "eyeLookUp_R"})
    out[face::shape_index(gaze)] = face::Provenance::predicted;
  return out;
}

}  // namespace mien::tracker::test
