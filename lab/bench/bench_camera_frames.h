#pragma once

#include <cstdint>

#include "lab/bench/paced.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"

namespace mien::lab {

/// What a headset's frame costs one thread, from four pictures of 240 x 240 as boards send them to weights:
/// sixty frames a second, with cold caches.
struct CameraFrameFigures {
  Spread whole;         ///< Decoding, features, and the tracker's frame.
  double decode_s = 0;  ///< Of a picture, hot; the smallest of rounds' medians, as all below.
  double encode_s = 0;  ///< Four pictures to features, decoding included.
  double frame_s = 0;   ///< The tracker's part: features to weights.
};

/// By the default model and rig. Errors: those of model, rig and wearer; cancelled.
[[nodiscard]] Result<CameraFrameFigures> measure_camera_frames(std::uint64_t seed, int frames,
                                                               const Progress& progress);

}  // namespace mien::lab
