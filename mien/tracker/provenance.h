#pragma once

#include <cstddef>
#include <cstdint>

#include "mien/face/output_frame.h"
#include "mien/model/confidence.h"

namespace mien::tracker {

/// Whether any of a tracker's sensors looks at the eyes.
enum class Gaze : std::uint8_t { unseen, seen };

/// Whether a shape is one of the eight that say where the eyes look: only what looks at the eyes can measure
/// it.
[[nodiscard]] inline bool is_gaze(std::size_t shape) {
  return face::kShapeNames[shape].starts_with("eyeLook");
}

/// What a model's table says of a shape in a bin of coverage: measured where the sensors explain enough of
/// its variance, else predicted; gaze, which no sensor on the skin sees, is always predicted.
[[nodiscard]] inline face::Provenance provenance_of(const model::ConfidenceTable& table, std::size_t shape,
                                                    std::size_t coverage_bin) {
  return table.explained_by(shape, coverage_bin) >= table.measured_from && !is_gaze(shape)
             ? face::Provenance::measured
             : face::Provenance::predicted;
}

/// The provenance of all 53 shapes of a tracker's answer that has no table of its shapes (FrameWriter reads
/// one): measured while a sensor is there, else predicted; gaze as is_gaze() says.
inline void set_provenance(bool sensor_is_there, Gaze gaze, face::OutputFrame& out) {
  using face::Provenance;
  out.provenance.fill(sensor_is_there ? Provenance::measured : Provenance::predicted);
  if (gaze == Gaze::seen) return;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (is_gaze(k)) out.provenance[k] = Provenance::predicted;
}

}  // namespace mien::tracker
