#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "app/live/perform_network.h"
#include "mien/core/error.h"
#include "mien/virtual/stage.h"

namespace mien::app {

/// Whether pictures are offered there: "http://HOST:PORT".
[[nodiscard]] bool is_camera_address(std::string_view to);

struct CameraOptions {
  std::string to;      ///< "http://HOST:PORT": of the first camera; the others follow on the next ports.
  double wait_s = 10;  ///< The performance begins unwatched after this.
  bool loop = false;   ///< Again and again, until it is stopped.
  /// Rendered first, then at the rig's size and rate. Else as it is rendered, smaller and slower.
  bool ahead = false;
  /// Where the performer has boards, too, which somebody else sends for: it begins when these are ready.
  SharedStart* start = nullptr;
};

/// What was offered.
struct CameraSummary {
  std::size_t cameras = 0;
  std::size_t watched = 0;  ///< Cameras whose pictures somebody had asked for when it began.
  double performed_s = 0;
  std::size_t rounds = 0;      ///< Times that the motion was begun.
  std::uint64_t pictures = 0;  ///< That were sent, or would have been.
  std::uint64_t skipped = 0;   ///< Shots that were left out, since they could not be rendered in time.
  std::uint64_t dropped = 0;   ///< Times that somebody was too slow.
  double latest_ms = 0;        ///< How late the latest picture went out.
  bool stopped = false;        ///< By its user, before the end.
};

/// Performs in real time before the cameras of a headset, each of which is a server of its own. Neither that
/// nobody asks nor a stop by Ctrl-C is an error. Errors: those of the stage and of HeadsetBoards; bad_usage
/// (no such address, a rig with no cameras, or with other sensors that nobody sends for, too long to be
/// rendered ahead);
/// not_found (no such host); io (a port that is taken).
[[nodiscard]] Result<CameraSummary> perform_to_cameras(const virt::StageRequest& request,
                                                       const CameraOptions& options);

}  // namespace mien::app
