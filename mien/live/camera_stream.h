#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/live/camera_pictures.h"
#include "mien/live/name_lookup.h"
#include "mien/sensor/payload_stream.h"

namespace mien::live {

/// A camera's stream, as a person types it: `http://HOST[:PORT][/PATH]`.
struct CameraAddress {
  std::string host;         ///< Name or number, in small letters, IPv6 without its brackets.
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
/// is lost, is no camera or gives no whole picture for CameraPictures::kPatience, it is asked again, after
/// 0.1 s first and every 2 s later: as serial lines are; after 0.1 s again once its pictures came for that
/// long. All calls from the thread that runs the io_context; while that may still run, this is not to be
/// destroyed. No allocation while pictures come.
class CameraStream {
 public:
  static constexpr auto kFirstRetry = std::chrono::milliseconds(100);
  static constexpr auto kLastRetry = std::chrono::seconds(2);

  using Clock = CameraPictures::Clock;
  /// Begins at once. `sensor`: as CameraStatus has it. `clock` is steady. `find`: who says where its host is.
  CameraStream(boost::asio::io_context& network, CameraAddress address, std::string sensor,
               std::unique_ptr<sensor::PayloadStream> stream, sensor::PayloadStream::OnPayload on_payload,
               Clock clock, NameLookup::Ask find = NameLookup::ask_system);
  CameraStream(const CameraStream&) = delete;
  CameraStream& operator=(const CameraStream&) = delete;
  ~CameraStream() { close(); }
  /// For good. Waits for nobody.
  void close();
  [[nodiscard]] CameraStatus status() const { return pictures_.status(); }

 private:
  /// A connection, or the wait for one: what belongs to one that is over is ignored, also when it is told of
  /// after the stream has gone.
  struct Attempt {
    std::shared_ptr<const std::uint64_t> newest;
    std::uint64_t number = 0;
    [[nodiscard]] bool is_over() const { return *newest != number; }
  };
  Attempt next_attempt() { return {newest_, ++*newest_}; }
  void ask();
  void ask_again();
  void connect(const Attempt& attempt, const NameLookup::Answer& host);
  void send_request(const Attempt& attempt);
  void read(const Attempt& attempt);
  void read_when_due(const Attempt& attempt, std::size_t size);
  void watch();
  void lose(const std::string& problem);

  CameraAddress address_;
  CameraPictures pictures_;
  Clock clock_;
  std::string request_;
  NameLookup lookup_;
  boost::asio::ip::tcp::socket socket_;
  boost::asio::steady_timer retry_;  // To ask again, or to read on.
  boost::asio::steady_timer watch_;
  std::array<std::byte, 16384> bytes_{};
  std::shared_ptr<std::uint64_t> newest_ = std::make_shared<std::uint64_t>(0);  // Attempt.
  bool asking_ = false;
  bool finding_ = false;  // Its host.
  std::chrono::milliseconds pause_ = kFirstRetry;
};

}  // namespace mien::live
