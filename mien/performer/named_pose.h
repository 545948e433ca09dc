#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/profile.h"

namespace mien::performer {

/// One still expression.
struct StillPose {
  face::BlendshapeWeights weights;
  float tongue_out = 0;
};

/// The names that people use first: "neutral", "smile", "laugh", "sad", "angry", ... in the order of the
/// help. Each is one of expression_library() under a plain word, or neutral.
[[nodiscard]] std::vector<std::string> plain_pose_names();

/// The pose of a plain name or of a name of expression_library() ("wink_L", "bare_teeth"). Errors: bad_usage
/// (an unknown name; says which is near, or the plain ones).
[[nodiscard]] Result<StillPose> named_pose(std::string_view name);

}  // namespace mien::performer
