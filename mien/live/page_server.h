#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"

namespace mien::live {

/// A file that the page server gives out. Lifetime: the server's, and longer.
struct Asset {
  std::string_view path;  ///< "/index.html"; "/" gives that one.
  std::string_view type;  ///< "text/html; charset=utf-8".
  std::span<const std::byte> bytes;
  bool open = true;  ///< Given without a token, too: it says nothing of the session.
  /// If set, it tells the bytes, which may take a while: called whenever they are asked for, and the request
  /// waits.
  std::function<std::shared_future<Result<std::vector<std::byte>>>()> make = nullptr;
};

struct PageSettings {
  std::string host = "127.0.0.1";
  std::uint16_t port = 8740;  ///< 0: any that is free.
  /// What requests must carry as `?token=`, but for open assets; empty only on loopback.
  std::string token;
  std::vector<Asset> assets;
};

/// Serves the page and its WebSocket (docs/reference/page_protocol.md). All calls from the thread that runs
/// the io_context. On loopback without a token only requests whose Host names loopback are answered, and
/// WebSockets only from pages of this server (docs/reference/threat_model.md). Clients, their queues and what
/// they may send are capped by constants; a slow one misses frames and is dropped when it misses replies.
class PageServer {
 public:
  /// Called with a client's number and its message.
  using OnMessage = std::function<void(std::uint64_t client, std::string_view text)>;
  /// Called with a client's number and its binary message.
  using OnBytes = std::function<void(std::uint64_t client, std::span<const std::byte> bytes)>;
  /// Called when a client is there; returns what is sent to it first.
  using OnOpen = std::function<std::string()>;

  /// Without `on_bytes` binary messages are left unread. Errors: bad_usage (no token on another address than
  /// loopback; the port is taken), not_found (no such address).
  [[nodiscard]] static Result<std::unique_ptr<PageServer>> open(boost::asio::io_context& network,
                                                                PageSettings settings, OnOpen on_open,
                                                                OnMessage on_message, OnBytes on_bytes = {});
  ~PageServer();

  /// Where a browser finds it, token and all.
  [[nodiscard]] std::string address() const;
  [[nodiscard]] std::size_t clients() const;
  /// Lets a client that is there send messages of so many bytes from now on: who sends longer ones is
  /// dropped.
  void allow_messages(std::uint64_t client, std::size_t bytes);
  /// Whether this client is still there.
  [[nodiscard]] bool has(std::uint64_t client) const;

  /// To everybody; a client that has not taken the last frame yet gets this one instead of it.
  void send_frame(std::string frame);
  /// To everybody, in order.
  void send(std::string message);
  /// A binary message to one client, if it is still there, after all else: one that has not taken the last of
  /// this camera yet gets this instead of it.
  void send_picture(std::uint64_t client, std::uint16_t camera, std::string message);
  /// To one client, if it is still there.
  void send(std::uint64_t client, std::string message);

 private:
  struct State;
  class Connection;
  explicit PageServer(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;
};

}  // namespace mien::live
