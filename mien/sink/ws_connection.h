#pragma once

// Asio 1.74 uses std::exchange without including this.
//
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <memory>
#include <optional>
#include <string>

namespace mien::sink {

/// One WebSocket to which frames go, from its handshake to its end. A slow reader gets the latest frame that
/// there is when it can take one; those in between are dropped, and nothing queues. What the other side sends
/// is read and ignored. All calls from the network's thread; it lives on its own while its socket has work.
class WsConnection : public std::enable_shared_from_this<WsConnection> {
 public:
  /// `hello` is sent first.
  WsConnection(boost::asio::ip::tcp::socket socket, std::shared_ptr<const std::string> hello);

  /// Somebody has connected to us: answers the upgrade, or refuses it (judge_upgrade).
  void serve(const std::string& token);
  /// Connects to somebody's server; `host` is for its Host header, `target` the path with its query.
  void connect(const boost::asio::ip::tcp::endpoint& endpoint, const std::string& host,
               const std::string& target);

  /// Takes a frame's message to send. False when it is not open, or when this displaces a frame that could
  /// not be sent yet.
  bool offer(const std::string& message);
  void close();

  [[nodiscard]] bool is_open() const { return state_ == State::open; }
  [[nodiscard]] bool is_ended() const { return state_ == State::ended; }

 private:
  enum class State { opening, open, ended };
  using Code = boost::system::error_code;
  using Request = boost::beast::http::request<boost::beast::http::string_body>;

  void judge();
  void refuse(boost::beast::http::status status, const char* why);
  void configure(boost::beast::role_type role);
  void opened();
  void read();
  void write();
  void ended();

  boost::beast::websocket::stream<boost::beast::tcp_stream> stream_;
  std::shared_ptr<const std::string> hello_;
  State state_ = State::opening;
  std::string token_;
  boost::beast::flat_buffer received_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::string_body>> parser_;
  std::optional<boost::beast::http::response<boost::beast::http::string_body>> refusal_;
  std::string sending_;
  std::string next_;
  bool writing_ = false;
  bool has_next_ = false;
};

}  // namespace mien::sink
