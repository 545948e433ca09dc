#include "mien/shaping/limits.h"

#include <algorithm>

namespace mien::shaping {

void Limits::apply(face::OutputFrame& frame) const {
  for (std::size_t i = 0; i < face::kShapeCount; ++i) {
    const ShapeLimits& shape = shapes[i];
    frame.weights[i] = std::min(std::max(shape.gain * frame.weights[i], shape.low), shape.high);
  }
}

}  // namespace mien::shaping
