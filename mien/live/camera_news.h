#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "mien/core/time.h"
#include "mien/live/camera_status.h"

namespace mien::live {

/// One camera's coming and going, in words for a person. Of one that comes and goes all the time its coming
/// and its going are each said every ten seconds, with how often it went meanwhile: a terminal has room for
/// few. A pure function of its calls.
class CameraNews {
 public:
  static constexpr Duration kQuiet = std::chrono::seconds(10);

  struct Sentence {
    std::string kind;  ///< "camera" or "camera_lost".
    std::string text;  ///< "http://192.168.1.7/: pictures come".
  };
  /// How the camera is now, of which something may be to be said. From time to time, `now` never runs back.
  [[nodiscard]] std::optional<Sentence> tell(HostTime now, const CameraStatus& camera);

 private:
  std::optional<HostTime> said_open_, said_lost_;  // When each was said last.
  std::string said_;                               // What was said last; empty: that they come, or nothing.
  bool said_anything_ = false;
  std::uint64_t losses_ = 0;  // That were told.
};

}  // namespace mien::live
