#pragma once

#include <span>
#include <vector>

#include "mien/core/time.h"
#include "mien/live/camera_news.h"
#include "mien/live/serial_port.h"

namespace mien::live {

/// Serial lines that are unplugged and back, and the cameras on them, in words for a person. A pure function
/// of its calls.
class LineNews {
 public:
  /// `lines`: always the same, in the same order. From time to time, `now` never runs back.
  [[nodiscard]] std::vector<CameraNews::Sentence> tell(HostTime now,
                                                       std::span<const SerialPort::Status> lines);

 private:
  struct Line {
    bool open = true;   // As it was said last.
    CameraNews camera;  // Once it is one's: that is told in place of the line.
  };
  std::vector<Line> lines_;
};

}  // namespace mien::live
