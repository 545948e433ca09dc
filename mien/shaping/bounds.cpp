#include "mien/shaping/bounds.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace mien::shaping {

void mend(face::OutputFrame& frame, const face::OutputFrame& last) {
  const auto share = [](float x) { return std::isfinite(x) ? std::clamp(x, 0.0f, 1.0f) : 0.0f; };
  std::array<bool, face::kShapeRegionCount> whole{};
  whole.fill(true);
  for (std::size_t i = 0; i < face::kShapeCount; ++i) {
    frame.confidence[i] = share(frame.confidence[i]);
    if (std::isfinite(frame.weights[i])) {
      frame.weights[i] = std::clamp(frame.weights[i], 0.0f, 1.0f);
      continue;
    }
    frame.weights[i] = last.weights[i];
    frame.confidence[i] = 0;
    frame.provenance[i] = face::Provenance::held;
    whole[static_cast<std::size_t>(face::kShapeRegions[i])] = false;
  }
  for (std::size_t r = 0; r < face::kShapeRegionCount; ++r)
    frame.region_confidence[r] = whole[r] ? share(frame.region_confidence[r]) : 0;
  frame.tongue_out =
      std::isfinite(frame.tongue_out) ? std::clamp(frame.tongue_out, 0.0f, 1.0f) : last.tongue_out;
  frame.head_confidence = share(frame.head_confidence);
  const double length = frame.head.norm();
  if (!(std::abs(length - 1) < 0.1)) {
    frame.head = last.head;
    frame.head_confidence = 0;
    frame.head_provenance = face::Provenance::held;
  } else if (std::abs(length - 1) > 1e-6) {
    frame.head.normalize();
  }
  if (frame.head_position_known && !frame.head_position_m.allFinite()) {
    frame.head_position_m = last.head_position_m;
    frame.head_position_known = last.head_position_known;
    frame.head_confidence = 0;
    frame.head_provenance = face::Provenance::held;
  }
  if (!frame.head_position_known) frame.head_position_m.setZero();
  frame.head_position_m = frame.head_position_m.cwiseMax(-kHeadAtMost_m).cwiseMin(kHeadAtMost_m);
  frame.eyes_confidence = share(frame.eyes_confidence);
  if (!frame.eyes_rad[0].allFinite() || !frame.eyes_rad[1].allFinite()) {
    frame.eyes_rad = last.eyes_rad;
    frame.eyes_confidence = 0;
    frame.eyes_provenance = face::Provenance::held;
  }
  for (Eigen::Vector2f& eye : frame.eyes_rad) eye = eye.cwiseMax(-kEyeAtMostRad).cwiseMin(kEyeAtMostRad);
}

void bound(face::OutputFrame& frame) {
  const auto share = [](float w) { return w > 0 ? std::min(w, 1.0f) : 0.0f; };  // Not a number: 0.
  for (float& w : frame.weights.values) w = share(w);
  frame.tongue_out = share(frame.tongue_out);
}

void bound_steps(face::OutputFrame& frame, const face::OutputFrame& before) {
  const auto most = static_cast<float>(kStepAtMost * kFrameRateHz * to_seconds(frame.time - before.time));
  const auto near = [most](float w, float was) { return std::clamp(w, was - most, was + most); };
  for (std::size_t i = 0; i < face::kShapeCount; ++i)
    frame.weights[i] = near(frame.weights[i], before.weights[i]);
  frame.tongue_out = near(frame.tongue_out, before.tongue_out);
}

}  // namespace mien::shaping
