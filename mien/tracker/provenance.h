#pragma once

#include <cstdint>

#include "mien/face/output_frame.h"

namespace mien::tracker {

/// Whether any of a tracker's sensors looks at the eyes.
enum class Gaze : std::uint8_t { unseen, seen };

/// The provenance of all 53 shapes of a tracker's answer: measured while a sensor is there, else predicted.
/// The eight eyeLook shapes are predicted where nothing looks at the eyes, whatever else is there.
inline void set_provenance(bool sensor_is_there, Gaze gaze, face::OutputFrame& out) {
  using face::Provenance;
  out.provenance.fill(sensor_is_there ? Provenance::measured : Provenance::predicted);
  if (gaze == Gaze::seen) return;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (face::kShapeNames[k].starts_with("eyeLook")) out.provenance[k] = Provenance::predicted;
}

}  // namespace mien::tracker
