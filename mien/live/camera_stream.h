#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/live/budget.h"
#include "mien/sensor/payload_stream.h"

namespace mien::live {

/// A camera's stream, as a person types it: `http://HOST[:PORT][/PATH]`.
struct CameraAddress {
  std::string host;         ///< Name or number, IPv6 without its brackets.
  std::uint16_t port = 80;  ///< Not 0.
  std::string path = "/";   ///< With its query.

  /// "http://192.168.1.7:81/stream": the source of what comes in there. The port stands in it unless it
  /// is 80.
  [[nodiscard]] std::string source() const;
};

/// Errors: bad_usage (another scheme, no host, a user or password, a fragment, over 100 letters, letters that
/// no address has).
[[nodiscard]] Result<CameraAddress> parse_camera_address(std::string_view text);

/// A camera in the network: asks for its stream (HTTP, GET), gives what comes to a sensor::PayloadStream and
/// hands on what comes out of that. One host is spoken to, the one that was named. When it cannot be reached,
/// is lost, is no camera or gives no whole picture for kPatience, it is asked again, after 0.1 s first and
/// every 2 s later: as serial lines are. All calls from the thread that runs the io_context; while that may
/// still run, this is not to be destroyed. No allocation while pictures come.
class CameraStream {
 public:
  static constexpr auto kFirstRetry = std::chrono::milliseconds(100);
  static constexpr auto kLastRetry = std::chrono::seconds(2);
  /// From its being asked to its first picture, and from one to the next. Raising bears slower cameras and
  /// worse radio; lowering finds one that hangs sooner.
  static constexpr Duration kPatience = std::chrono::seconds(2);
  /// Bytes a second that are read, a second's worth at once; what comes faster waits in the network. A
  /// board's 60 pictures a second of 240 x 240 pixels are 0.3e6 to 0.5e6.
  static constexpr double kMaxBytesPerSecond = 8e6;
  /// Pictures a second that are handed on. The fastest cameras of headsets give 120.
  static constexpr double kMaxPicturesPerSecond = 130;

  using Clock = std::function<HostTime()>;
  /// Begins at once. `clock` is steady.
  CameraStream(boost::asio::io_context& network, CameraAddress address,
               std::unique_ptr<sensor::PayloadStream> stream, sensor::PayloadStream::OnPayload on_payload,
               Clock clock);
  CameraStream(const CameraStream&) = delete;
  CameraStream& operator=(const CameraStream&) = delete;
  /// For good.
  void close();

  struct Status {
    std::string address;      ///< As CameraAddress::source().
    bool open = false;        ///< Pictures come.
    std::string problem;      ///< Why they do not; empty while they do, and before anything is known.
    std::uint64_t lost = 0;   ///< Times that they had come and ended.
    std::uint64_t bytes = 0;  ///< Read.
    sensor::StreamCounts pictures;
    std::uint64_t too_fast = 0;   ///< Whole pictures that were not handed on: more than a camera's rate.
    std::uint64_t held_back = 0;  ///< Times that it was read later, since it sent more bytes than a camera.
  };
  [[nodiscard]] Status status() const;

 private:
  void ask();
  void ask_again();
  void send_request(std::uint64_t attempt);
  void read(std::uint64_t attempt);
  void read_when_due(std::uint64_t attempt, std::size_t size);
  void watch();
  void lose(const std::string& problem);
  [[nodiscard]] std::string no_picture() const;

  CameraAddress address_;
  std::unique_ptr<sensor::PayloadStream> stream_;
  sensor::PayloadStream::OnPayload on_payload_;  // The caller's behind the limit of pictures.
  Clock clock_;
  std::string request_;
  boost::asio::ip::tcp::resolver resolver_;
  boost::asio::ip::tcp::socket socket_;
  boost::asio::steady_timer retry_;  // To ask again, or to read on.
  boost::asio::steady_timer watch_;
  std::array<std::byte, 16384> bytes_{};
  std::uint64_t attempt_ = 0;  // What belongs to one before is ignored.
  bool open_ = false;
  bool asking_ = false;
  HostTime deadline_;  // Of the next whole picture.
  std::chrono::milliseconds pause_ = kFirstRetry;
  Budget byte_budget_{.tokens = kMaxBytesPerSecond};
  Budget picture_budget_{.tokens = kMaxPicturesPerSecond};
  std::string problem_;
  std::uint64_t overlong_before_ = 0;  // Pictures of the connections before.
  std::uint64_t lost_ = 0;
  std::uint64_t received_ = 0;
  std::uint64_t too_fast_ = 0;
  std::uint64_t held_back_ = 0;
};

}  // namespace mien::live
