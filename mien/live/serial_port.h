#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/serial_port.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/live/camera_pictures.h"
#include "mien/sensor/payload_stream.h"
#include "mien/sensor/stream_framer.h"

namespace mien::live {

/// A serial line, as a person types it: `serial:/dev/ttyUSB0[?baud=250000]`.
struct SerialAddress {
  std::string device;           ///< Absolute path.
  std::uint32_t baud = 250000;  ///< Bits a second, 300 to 4,000,000.

  /// "serial:/dev/ttyUSB0": the source of what comes in there.
  [[nodiscard]] std::string source() const { return "serial:" + device; }
};

/// Errors: bad_usage (no path, an option that is unknown, a rate out of range).
[[nodiscard]] Result<SerialAddress> parse_serial_address(std::string_view text);

/// Whose pictures a line's are, where a camera speaks on it, and what finds them.
struct LineCamera {
  std::string sensor;  ///< As CameraStatus has it.
  std::unique_ptr<sensor::PayloadStream> stream;
};

/// What comes in on a serial line: frames (sensor::StreamFramer), or a camera's pictures. Of a line that may
/// be a camera's both are looked for, and frames no more once a picture came, until it is opened anew: what
/// stands in a picture is no device's. When the line is unplugged it is opened again once it is back, tried
/// after 0.1 s first and every 2 s later. A camera that gives no picture for CameraPictures::kPatience is
/// said to have stalled, and its line stays open: to open it begins many boards anew, which may take longer
/// than that. Nothing is ever sent. All calls from the thread that runs the io_context. No allocation while
/// the line stays open.
class SerialPort {
 public:
  static constexpr auto kFirstRetry = std::chrono::milliseconds(100);
  static constexpr auto kLastRetry = std::chrono::seconds(2);

  /// Called with each frame; valid during the call.
  using OnFrame = std::function<void(std::span<const std::byte> frame)>;

  /// Opens the line: raw, eight bits, no parity, one stop bit, no flow control. `camera`: where the line may
  /// be one's, whose pictures go to `on_payload`. `clock` is steady. Errors: not_found (no such device),
  /// bad_usage (no serial line, not allowed, taken by another program, a rate it cannot do).
  [[nodiscard]] static Result<std::unique_ptr<SerialPort>> open(
      boost::asio::io_context& network, SerialAddress address, OnFrame on_frame,
      std::optional<LineCamera> camera = std::nullopt, sensor::PayloadStream::OnPayload on_payload = {},
      CameraPictures::Clock clock = {});
  /// For good.
  void close();

  struct Status {
    std::string address;  ///< As SerialAddress::source().
    bool open = false;
    std::string problem;          ///< Why it is not; empty while it is open.
    std::uint64_t unplugged = 0;  ///< Times that it was lost.
    std::uint64_t bytes = 0;
    std::uint64_t overlong = 0;          ///< Frames that were longer than a device's, dropped.
    std::optional<CameraStatus> camera;  ///< There once a picture came.
  };
  [[nodiscard]] Status status() const;

 private:
  SerialPort(boost::asio::io_context& network, SerialAddress address, OnFrame on_frame);
  Result<void> try_open();
  void read();
  void read_when_due(std::size_t size);
  void take(std::span<const std::byte> bytes);
  void watch();
  void lose(const std::string& problem);
  void retry();

  SerialAddress address_;
  OnFrame on_frame_;
  boost::asio::serial_port port_;
  std::unique_ptr<CameraPictures> camera_;  // Null: the line is none's.
  boost::asio::steady_timer timer_;         // To try again, or to read on.
  boost::asio::steady_timer watch_;
  std::array<std::byte, 4096> bytes_{};
  sensor::StreamFramer framer_;
  std::chrono::milliseconds pause_ = kFirstRetry;
  std::string problem_;
  std::uint64_t unplugged_ = 0;
  std::uint64_t received_ = 0;
  bool closed_ = false;
};

}  // namespace mien::live
