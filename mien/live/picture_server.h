#pragma once

#include <boost/asio/io_context.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "mien/core/error.h"
#include "mien/core/time.h"

namespace mien::live {

/// One camera as boards with OpenIris offer theirs over HTTP: whoever asks (GET, any path) gets its pictures
/// from then on, multipart and chunked, each with its time, by the boards' own headers
/// (docs/reference/protocol.md, type 15). Not for the open internet. All calls but counts() from the thread
/// that runs the io_context.
class PictureServer {
 public:
  /// More at once are told to come later.
  static constexpr std::size_t kMaxClients = 16;
  /// Pictures that wait for one client. Who is behind by more is dropped, and may ask again: a stream is
  /// never late for all.
  static constexpr std::size_t kMaxWaiting = 16;

  struct Settings {
    std::string host = "127.0.0.1";  ///< Which of this machine's addresses; a name is resolved.
    std::uint16_t port = 0;          ///< 0: any that is free.
    double rate_hz = 60;             ///< As X-Framerate tells it, rounded.
    std::size_t most_waiting = kMaxWaiting;
  };
  /// Listens at once. Errors: not_found (no such host), io (the port is taken, or not allowed).
  [[nodiscard]] static Result<std::unique_ptr<PictureServer>> open(boost::asio::io_context& network,
                                                                   const Settings& settings);
  PictureServer(const PictureServer&) = delete;
  PictureServer& operator=(const PictureServer&) = delete;
  ~PictureServer();  ///< As close().

  [[nodiscard]] std::uint16_t port() const;
  /// One picture, to all who have asked; copied once for all. `time`: of the camera's clock, not below 0.
  void send(DeviceTime time, std::span<const std::byte> jpeg);
  /// What waits for clients is not sent any more, and nobody is listened to.
  void close();

  struct Counts {
    std::size_t clients = 0;     ///< That get pictures now.
    std::uint64_t pictures = 0;  ///< Handed to send().
    std::uint64_t dropped = 0;   ///< Clients that were too slow.
  };
  /// From any thread.
  [[nodiscard]] Counts counts() const;

 private:
  class Client;
  struct State;
  explicit PictureServer(std::shared_ptr<State> state) : state_(std::move(state)) {}
  std::shared_ptr<State> state_;
};

}  // namespace mien::live
