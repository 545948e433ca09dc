#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "mien/core/time.h"
#include "mien/headset/picture_collector.h"

namespace mien::headset {

/// Takes the pictures out of the body of an HTTP response of the type multipart/x-mixed-replace, as cameras
/// send it. Pictures are found by their own markers, from FF D8 FF to their end, and not by boundaries and
/// lengths: there are cameras without them, and a wrong one then does no harm. Of the lines between pictures
/// only X-Timestamp is read. A picture that ends too early costs itself alone, but where a segment of its
/// header swallows the next one's beginning. Whether what was found can be decoded is for jpeg_gate.h. No
/// allocation after construction. Thread: one at a time.
class MultipartReader {
 public:
  struct Picture {
    std::span<const std::byte> jpeg;  ///< Valid until the next call.
    /// X-Timestamp, seconds of the camera's clock, whole microseconds. Of clocks that count from 1970 the
    /// rest over 1e8 s, three years, so that it is one of sensor::read_device_time's.
    std::optional<DeviceTime> time;
  };

  /// Another body begins. What was open is broken.
  void restart();
  /// Reads from the front of `bytes`, which is moved behind what was read: the next picture that is whole, or
  /// none, when all was read.
  std::optional<Picture> read(std::span<const std::byte>& bytes);
  [[nodiscard]] const sensor::StreamCounts& counts() const { return pictures_.counts(); }

 private:
  void add_to_line(char c);
  void end_line();
  void read_lines_of_broken();

  PictureCollector pictures_;
  /// What is longer is no line that we need.
  std::array<char, 64> line_{};
  std::size_t line_size_ = 0;
  std::optional<DeviceTime> time_;
};

/// The time of an X-Timestamp, "12.345678": seconds, and up to six digits of their fraction. None where it is
/// anything else. Beyond 1e8 s as MultipartReader::Picture::time.
[[nodiscard]] std::optional<DeviceTime> parse_timestamp(std::string_view text);

}  // namespace mien::headset
