#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/live/budget.h"
#include "mien/sensor/payload_stream.h"

namespace mien::live {

/// How a camera's connection is.
struct CameraStatus {
  std::string address;      ///< "http://192.168.1.7:81/stream", "serial:/dev/ttyACM0".
  std::string sensor;       ///< Whose pictures they are, as the rig names it.
  bool open = false;        ///< Pictures come.
  std::string problem;      ///< Why they do not; empty while they do, and before anything is known.
  std::uint64_t lost = 0;   ///< Times that they had come and ended.
  std::uint64_t bytes = 0;  ///< Read.
  sensor::StreamCounts pictures;
  std::vector<sensor::Refusal> refusals;  ///< Of pictures.refused, the most frequent reason first.
  std::uint64_t too_fast = 0;   ///< Whole pictures that were not handed on: more than a camera's rate.
  std::uint64_t held_back = 0;  ///< Times that it was read later, since it sent more bytes than a camera.
};

/// A camera's pictures, whatever it is connected by: the bytes that come are given to a
/// sensor::PayloadStream, and what comes out of that is handed on, at most as fast as a camera gives
/// pictures. Knows whether they still come. Thread: one at a time. No allocation while pictures come.
class CameraPictures {
 public:
  /// From a connection's beginning to its first picture, and from one to the next. Raising bears slower
  /// cameras and worse radio; lowering finds one that hangs sooner.
  static constexpr Duration kPatience = std::chrono::seconds(2);
  /// Bytes a second that are to be read, a second's worth at once. A board's 60 pictures a second of 240 x
  /// 240 pixels are 0.3e6 to 0.5e6.
  static constexpr double kMaxBytesPerSecond = 8e6;
  /// Pictures a second that are handed on. The fastest cameras of headsets give 120.
  static constexpr double kMaxPicturesPerSecond = 130;

  using Clock = std::function<HostTime()>;
  /// `address` and `sensor`: as CameraStatus has them. `clock` is steady.
  CameraPictures(std::string address, std::string sensor, std::unique_ptr<sensor::PayloadStream> stream,
                 sensor::PayloadStream::OnPayload on_payload, Clock clock);
  CameraPictures(const CameraPictures&) = delete;
  CameraPictures& operator=(const CameraPictures&) = delete;

  /// A connection begins, or is asked for.
  void begin();
  /// What came in on it. Errors: PayloadStream::read's.
  [[nodiscard]] Result<void> read(std::span<const std::byte> bytes);
  /// Whether what was read may be followed by more now. False: it is to be asked again a little later.
  [[nodiscard]] bool may_read_on(std::size_t read_bytes);
  /// The connection is over; empty: for a reason that is told elsewhere.
  void end(std::string problem);

  [[nodiscard]] bool open() const { return status_.open; }
  /// Since when pictures come without a break.
  [[nodiscard]] HostTime open_since() const { return open_since_; }
  /// No whole picture came for kPatience.
  [[nodiscard]] bool is_overdue() const { return clock_() >= deadline_; }
  /// What to say of that.
  [[nodiscard]] std::string no_picture() const;
  /// Whether the connection gave a whole picture so far, if only one that was refused.
  [[nodiscard]] bool has_spoken() const { return whole(stream_->counts()) > whole(at_begin_); }
  [[nodiscard]] CameraStatus status() const;

 private:
  static std::uint64_t whole(const sensor::StreamCounts& counts) { return counts.whole + counts.refused; }

  std::unique_ptr<sensor::PayloadStream> stream_;
  sensor::PayloadStream::OnPayload on_payload_;  // The caller's behind the limit of pictures.
  Clock clock_;
  CameraStatus status_;             // But for what the stream counts.
  sensor::StreamCounts at_begin_;   // Of the connections before.
  HostTime deadline_, open_since_;  // The first: of the next whole picture.
  Budget bytes_{.tokens = kMaxBytesPerSecond};
  Budget pictures_{.tokens = kMaxPicturesPerSecond};
};

}  // namespace mien::live
