#include "mien/shaping/fading.h"

#include <algorithm>

#include "mien/core/smoothstep.h"
#include "mien/shaping/frame_parts.h"

namespace mien::shaping {

using face::Provenance;

Fading::Fading(double age_s, const FallbackSettings& settings)
    : gone_(smoothstep((age_s - settings.hold_s) / settings.neutral_s)),
      left_(static_cast<float>(1 - gone_)),
      confidence_share_(
          static_cast<float>(std::clamp(1 - age_s / (settings.hold_s + settings.neutral_s), 0.0, 1.0))),
      held_(age_s <= settings.hold_s) {}

Provenance Fading::provenance_of(Provenance was) const {
  return was == Provenance::neutral || !held_ ? Provenance::neutral : Provenance::held;
}

void Fading::apply(std::size_t part, const face::OutputFrame& from, face::OutputFrame& frame) const {
  if (part < face::kShapeCount) {
    frame.weights[part] = left_ * from.weights[part];
    frame.confidence[part] = confidence_share_ * from.confidence[part];
    frame.provenance[part] = provenance_of(from.provenance[part]);
  } else if (part == kTonguePart) {
    frame.tongue_out = left_ * from.tongue_out;
  } else if (part == kHeadPart) {
    const Quat upright = twist_about(from.head, Vec3::UnitY());
    frame.head =
        gone_ > 0 ? canonical(exp_rotation(gone_ * log_rotation(upright * from.head.conjugate())) * from.head)
                  : from.head;
    frame.head_confidence = confidence_share_ * from.head_confidence;
    frame.head_provenance = provenance_of(from.head_provenance);
  } else if (part == kEyesPart) {
    for (std::size_t e = 0; e < 2; ++e) frame.eyes_rad[e] = left_ * from.eyes_rad[e];
    frame.eyes_confidence = confidence_share_ * from.eyes_confidence;
    frame.eyes_provenance = provenance_of(from.eyes_provenance);
  } else {
    copy_part(from, part, frame);
  }
}

}  // namespace mien::shaping
