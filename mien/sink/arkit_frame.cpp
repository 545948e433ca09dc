#include "mien/sink/arkit_frame.h"

#include <algorithm>
#include <cmath>

namespace mien::sink {
namespace {

/// No eye turns so far; keeps the tangents of these angles within bounds.
constexpr float kMaxEyeRad = 1.5F;

bool seen(face::Provenance provenance) {
  return provenance == face::Provenance::measured || provenance == face::Provenance::interpolated;
}

/// A lid that sensors tell or let guess, or that is held: whatever a tracker makes of sensors that are there.
bool followed(face::Provenance provenance) {
  return seen(provenance) || provenance == face::Provenance::predicted ||
         provenance == face::Provenance::held;
}

float within(float value, float least, float most) {
  return std::isfinite(value) ? std::clamp(value, least, most) : 0.0F;
}

}  // namespace

Quat sendable_rotation(const Quat& q) {
  const double norm = q.norm();
  return std::isfinite(norm) && norm > 0.5 ? canonical(q) : Quat::Identity();
}

ArkitFrame arkit_frame(const face::OutputFrame& frame) {
  ArkitFrame arkit;
  face::BlendshapeWeights weights;
  for (std::size_t i = 0; i < face::kShapeCount; ++i) weights[i] = within(frame.weights[i], 0.0F, 1.0F);
  arkit.weights = face::arkit_from_ict(weights, within(frame.tongue_out, 0.0F, 1.0F), true);
  arkit.head = sendable_rotation(frame.head);
  arkit.head_position_known = frame.head_position_known;
  if (frame.head_position_known)
    for (int k = 0; k < 3; ++k)
      arkit.head_position_m[k] = within(frame.head_position_m[k], -kMostHead_m, kMostHead_m);
  for (std::size_t eye = 0; eye < 2; ++eye)
    for (int k = 0; k < 2; ++k)
      arkit.eyes_rad[eye][k] = within(frame.eyes_rad[eye][k], -kMaxEyeRad, kMaxEyeRad);
  arkit.face_tracked = std::ranges::any_of(frame.provenance,
                                           [](face::Provenance p) { return p != face::Provenance::neutral; });
  arkit.eyes_tracked = seen(frame.eyes_provenance);
  for (const std::size_t lid : {face::shape("eyeBlink_L"), face::shape("eyeBlink_R")})
    arkit.lids_tracked = arkit.lids_tracked || followed(frame.provenance[lid]);
  return arkit;
}

}  // namespace mien::sink
