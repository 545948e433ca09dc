#include "mien/shaping/lids.h"

#include <algorithm>

#include "mien/shaping/eyes.h"

namespace mien::shaping {
namespace {

std::array<std::size_t, 4> shapes_of(const EyeShapes& eye) {
  return {eye.left, eye.right, eye.up, eye.down};
}

bool has_provenance(const face::OutputFrame& frame, const EyeShapes& eye, face::Provenance provenance) {
  return std::ranges::any_of(shapes_of(eye),
                             [&](std::size_t i) { return frame.provenance[i] == provenance; });
}

/// `angle` in rad; an opposite turn gives 0.
float weight_of(float angle) {
  return std::clamp(angle / kEyeTurnRad, 0.0F, 1.0F);
}

void follow_eye(const EyeShapes& eye, const Eigen::Vector2f& direction, face::OutputFrame& frame) {
  frame.weights[eye.left] = weight_of(direction.x());
  frame.weights[eye.right] = weight_of(-direction.x());
  frame.weights[eye.up] = weight_of(direction.y());
  frame.weights[eye.down] = weight_of(-direction.y());
  for (const std::size_t i : shapes_of(eye)) {
    frame.confidence[i] = frame.eyes_confidence;
    frame.provenance[i] = frame.eyes_provenance;
  }
}

}  // namespace

void Lids::apply(face::OutputFrame& frame, bool follow, double return_s) {
  using face::Provenance;
  for (std::size_t e = 0; e < 2; ++e) {
    const EyeShapes& eye = kEyeShapes[e];
    const bool was = follow_[e];
    const bool held =
        frame.eyes_provenance == Provenance::held && has_provenance(frame, eye, Provenance::held);
    const bool observed = has_provenance(frame, eye, Provenance::measured) ||
                          has_provenance(frame, eye, Provenance::interpolated);
    follow_[e] = follow && has_eyes(frame) && !observed && (was || !held);
    if (follow_[e]) follow_eye(eye, frame.eyes_rad[e], frame);
    if (begun_ && follow_[e] != was)
      for (const std::size_t i : shapes_of(eye)) ease_out_.begin(i, shown_, frame);
  }
  if (begun_) ease_out_.apply(frame, to_seconds(frame.time - shown_.time), return_s);
  shown_ = frame;
  begun_ = true;
}

}  // namespace mien::shaping
