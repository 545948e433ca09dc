#pragma once

#include <cstddef>

#include "mien/face/output_frame.h"
#include "mien/model/confidence.h"

namespace mien::tracker {

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

}  // namespace mien::tracker
