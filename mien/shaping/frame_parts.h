#pragma once

#include <cstddef>

#include "mien/face/output_frame.h"

namespace mien::shaping {

/// Numbers of the parts of an output frame that are merged and faded separately: the 53 shapes by their
/// index, each with its confidence and provenance, then these.
inline constexpr std::size_t kTonguePart = face::kShapeCount;
inline constexpr std::size_t kHeadPart = kTonguePart + 1;
inline constexpr std::size_t kEyesPart = kHeadPart + 1;
/// Goes with the head, but may be unknown while the head is not.
inline constexpr std::size_t kPositionPart = kEyesPart + 1;
inline constexpr std::size_t kPartCount = kPositionPart + 1;

/// Copies one part of a frame into another, to the bit. `part` < kPartCount.
inline void copy_part(const face::OutputFrame& from, std::size_t part, face::OutputFrame& out) {
  if (part < face::kShapeCount) {
    out.weights[part] = from.weights[part];
    out.confidence[part] = from.confidence[part];
    out.provenance[part] = from.provenance[part];
  } else if (part == kTonguePart) {
    out.tongue_out = from.tongue_out;
  } else if (part == kHeadPart) {
    out.head = from.head;
    out.head_confidence = from.head_confidence;
    out.head_provenance = from.head_provenance;
  } else if (part == kEyesPart) {
    out.eyes_rad = from.eyes_rad;
    out.eyes_confidence = from.eyes_confidence;
    out.eyes_provenance = from.eyes_provenance;
  } else {
    out.head_position_m = from.head_position_m;
    out.head_position_known = from.head_position_known;
  }
}

}  // namespace mien::shaping
