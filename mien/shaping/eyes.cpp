#include "mien/shaping/eyes.h"

#include <array>

namespace mien::shaping {
namespace {

using face::Provenance;
using face::shape;

struct Eye {
  std::size_t left;  // Shapes that turn it to the performer's left, right, up and down.
  std::size_t right;
  std::size_t up;
  std::size_t down;
};
constexpr std::array<Eye, 2> kEyes = {
    Eye{shape("eyeLookOut_L"), shape("eyeLookIn_L"), shape("eyeLookUp_L"), shape("eyeLookDown_L")},
    Eye{shape("eyeLookIn_R"), shape("eyeLookOut_R"), shape("eyeLookUp_R"), shape("eyeLookDown_R")}};

}  // namespace

void eyes_from_weights(face::OutputFrame& frame) {
  if (frame.eyes_provenance != Provenance::neutral || frame.eyes_confidence > 0) return;
  float confidence = 0;
  for (std::size_t e = 0; e < 2; ++e) {
    const Eye& eye = kEyes[e];
    const face::BlendshapeWeights& w = frame.weights;
    frame.eyes_rad[e] = kEyeTurnRad * Eigen::Vector2f(w[eye.left] - w[eye.right], w[eye.up] - w[eye.down]);
    for (const std::size_t i : {eye.left, eye.right, eye.up, eye.down}) confidence += frame.confidence[i] / 8;
  }
  const Provenance shapes = frame.provenance[kEyes[0].left];
  const bool observed = shapes == Provenance::measured || shapes == Provenance::interpolated;
  frame.eyes_provenance = observed ? Provenance::predicted : shapes;
  frame.eyes_confidence = kGazeConfidence * confidence;
}

}  // namespace mien::shaping
