#include "mien/tracker/calm.h"

#include "mien/core/time.h"

namespace mien::tracker {

void Calm::apply(face::BlendshapeWeights& weights) {
  const DeviceTime now = DeviceTime{} + frame_offset(frames_++);
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    weights[k] = static_cast<float>(filters_[k].filter(now, weights[k]));
}

}  // namespace mien::tracker
