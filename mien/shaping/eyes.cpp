#include "mien/shaping/eyes.h"

namespace mien::shaping {

void eyes_from_weights(face::OutputFrame& frame) {
  using face::Provenance;
  if (has_eyes(frame)) return;
  float confidence = 0;
  for (std::size_t e = 0; e < 2; ++e) {
    const EyeShapes& eye = kEyeShapes[e];
    const face::BlendshapeWeights& w = frame.weights;
    frame.eyes_rad[e] = kEyeTurnRad * Eigen::Vector2f(w[eye.left] - w[eye.right], w[eye.up] - w[eye.down]);
    for (const std::size_t i : {eye.left, eye.right, eye.up, eye.down}) confidence += frame.confidence[i] / 8;
  }
  const Provenance shapes = frame.provenance[kEyeShapes[0].left];
  const bool observed = shapes == Provenance::measured || shapes == Provenance::interpolated;
  frame.eyes_provenance = observed ? Provenance::predicted : shapes;
  frame.eyes_confidence = kGazeConfidence * confidence;
}

}  // namespace mien::shaping
