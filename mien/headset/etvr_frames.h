#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "mien/headset/picture_collector.h"

namespace mien::headset {

/// Takes the pictures out of what EyeTrackVR's boards send over a serial line: frames of FF A0 FF A1, the
/// picture's length (u16, little-endian), and the picture, which begins with FF D8. A picture that does not
/// end where its length says lost bytes or gained some: it is broken. Wherever the eight bytes stand a frame
/// begins, also within what was taken for a picture: the reader is right again with the next frame. No
/// allocation after construction. Thread: one at a time.
class EtvrFrames {
 public:
  /// The line was opened anew. What was open is broken.
  void restart() { pictures_.restart(); }
  /// Reads from the front of `bytes`, which is moved behind what was read: the next picture that is whole,
  /// valid until the next call; or none, when all was read.
  std::optional<std::span<const std::byte>> read(std::span<const std::byte>& bytes);
  [[nodiscard]] const sensor::StreamCounts& counts() const { return pictures_.counts(); }

 private:
  PictureCollector pictures_;
};

}  // namespace mien::headset
