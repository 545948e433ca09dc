#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mien/core/time.h"
#include "mien/live/camera_pictures.h"
#include "mien/live/sentence.h"
#include "mien/live/serial_port.h"

namespace mien::live {

/// One camera's coming and going, in words for a person. Of one that comes and goes all the time its coming
/// and its going are each said every ten seconds, with how often it went meanwhile: a terminal has room for
/// few. A pure function of its calls.
class CameraNews {
 public:
  static constexpr Duration kQuiet = std::chrono::seconds(10);

  /// How the camera is now, of which something may be to be said: "camera" or "camera_lost", with
  /// "http://192.168.1.7/: pictures come". From time to time, `now` never runs back.
  [[nodiscard]] std::optional<Sentence> tell(HostTime now, const CameraStatus& camera);

 private:
  std::optional<HostTime> said_open_, said_lost_;  // When each was said last.
  std::string said_;                               // What was said last; empty: that they come, or nothing.
  bool said_anything_ = false;
  std::uint64_t losses_ = 0;  // That were told.
};

/// Serial lines that are unplugged and back, and the cameras on them, in words for a person. A pure function
/// of its calls.
class LineNews {
 public:
  /// `lines`: always the same, in the same order. From time to time, `now` never runs back.
  [[nodiscard]] std::vector<Sentence> tell(HostTime now, std::span<const SerialPort::Status> lines);

 private:
  struct Line {
    bool open = true;   // As it was said last.
    CameraNews camera;  // Once it is one's: that is told in place of the line.
  };
  std::vector<Line> lines_;
};

}  // namespace mien::live
