#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/feeds.h"
#include "mien/live/serial_port.h"
#include "mien/sensor/rig.h"

namespace mien::app {

/// Whether what `--listen` names is a camera that is asked for its pictures, and not a place to listen on.
[[nodiscard]] bool is_camera(std::string_view address);

/// The cameras among what a session listens on.
struct ListenedCameras {
  std::vector<live::Feed> feeds;                  ///< Of those that are asked.
  std::map<std::string, live::LineCamera> lines;  ///< Those that may speak on serial lines, by address.
  std::vector<std::pair<std::string, std::string>> all;  ///< Each one's address, and its sensor's name.
  std::vector<std::uint16_t> sensors;                    ///< Their numbers in the rig, in the same order.
};

/// Each address of a camera (live::parse_camera_address) and each serial line is for the rig's next camera,
/// in their order: pictures come as from the device that the rig binds there. Serial lines beyond the rig's
/// cameras, or of one that is bound to no device, are other devices'. What stands between a camera and its
/// pictures is told as it changes. Errors: parse_camera_address's, parse_serial_address's, sensor::bindings';
/// bad_usage (more that are asked than the rig has, or one of a rig's that is bound to no device).
[[nodiscard]] Result<ListenedCameras> listened_cameras(const std::vector<std::string>& listen,
                                                       const sensor::Rig& rig);

/// What the pictures of cameras are expected to take, bytes an hour: at least and at most.
struct PictureBytes {
  double least = 0;
  double most = 0;
};
/// `cameras`: sensors of the rig.
[[nodiscard]] PictureBytes picture_bytes_an_hour(const sensor::Rig& rig,
                                                 const std::vector<std::uint16_t>& cameras);

}  // namespace mien::app
