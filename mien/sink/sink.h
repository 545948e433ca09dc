#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/face/output_frame.h"

namespace boost::asio {
class io_context;
}

namespace mien::sink {

/// How a sink is doing; for people.
struct Status {
  std::string address;       ///< As it was given.
  std::uint64_t sent = 0;    ///< Frames that went out and were not refused.
  std::uint64_t failed = 0;  ///< Frames that did not: nobody there, the machine would not take them.
  double rate_hz = 0;        ///< Frames sent a second, over the last 60 frames of the session.
  /// Who is known to listen. UDP does not tell: none there, unless all is refused: 0.
  std::optional<std::size_t> receivers;
  std::string note;  ///< One line about what is wrong or waited for; empty when all is well.
};

/// One place where output frames go. All calls from the thread that runs the io_context it was opened with;
/// destroy it there too, or after that has stopped.
class Sink {
 public:
  Sink() = default;
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;
  virtual ~Sink() = default;

  /// Sends one frame, or leaves it out where the sink's rate says so. Never blocks, never throws, allocates
  /// nothing after the first frames; what cannot be sent at once is counted and dropped. `frame_index` counts
  /// the 60 Hz grid; frames may be missing from it.
  virtual void send(const face::OutputFrame& frame, std::int64_t frame_index) noexcept = 0;
  [[nodiscard]] virtual Status status() const = 0;
};

/// Opens `livelink://`, `vmc://`, `vrchat://`, `ifacialmocap://` or `ws://` with HOST[:PORT], or `csv:FILE`,
/// with their options: docs/reference/sinks.md. Host names are resolved here and once, which may take
/// seconds. Errors: bad_usage (an address that cannot be meant; an unknown kind is answered with the known
/// ones), out_of_range, unsupported, not_found (no such host or file), io, and those of an option's file;
/// each names the address as it was given.
[[nodiscard]] Result<std::unique_ptr<Sink>> open_sink(boost::asio::io_context& network,
                                                      std::string_view address);

}  // namespace mien::sink
