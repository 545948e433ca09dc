#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/feeds.h"
#include "mien/sensor/rig.h"

namespace mien::app {

/// Whether what `--listen` names is a camera that is asked for its pictures, and not a place to listen on.
[[nodiscard]] bool is_camera(std::string_view address);

/// The streams of these cameras (live::parse_camera_address), each for one camera of the rig, in its order:
/// their pictures come as from the device that the rig binds there. What stands between a camera and its
/// pictures is told as it changes. Errors: parse_camera_address's, sensor::bindings'; bad_usage (more than
/// the rig has, or one of a rig's that is bound to no device).
[[nodiscard]] Result<std::vector<live::Feed>> camera_feeds(const std::vector<std::string>& addresses,
                                                           const sensor::Rig& rig);

/// What the pictures of a rig's cameras are expected to take, bytes an hour: at least and at most.
struct PictureBytes {
  double least = 0;
  double most = 0;
};
[[nodiscard]] PictureBytes picture_bytes_an_hour(const sensor::Rig& rig);

}  // namespace mien::app
