#include "mien/sink/ws_connection.h"

#include <boost/asio/buffer.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>

#include "mien/sink/ws_admission.h"

namespace mien::sink {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;

constexpr auto kHandshake = std::chrono::seconds(5);
/// Without a sign of life; half of it after the last, a ping asks for one.
constexpr auto kIdle = std::chrono::seconds(20);
/// What may wait in the machine for a reader who does not read: about a third of a second of frames.
constexpr int kSendBuffer = 16 * 1024;
/// Nobody has anything to tell us: what is longer than this ends the connection.
constexpr std::size_t kMaxReceived = 4096;
constexpr std::uint32_t kMaxHeader = 8192;

}  // namespace

WsConnection::WsConnection(boost::asio::ip::tcp::socket socket, std::shared_ptr<const std::string> hello)
    : stream_(std::move(socket)), hello_(std::move(hello)) {}

void WsConnection::configure(beast::role_type role) {
  auto times = websocket::stream_base::timeout::suggested(role);
  times.handshake_timeout = kHandshake;
  times.idle_timeout = kIdle;
  times.keep_alive_pings = true;
  stream_.set_option(times);
  stream_.read_message_max(kMaxReceived);
  stream_.text(true);
  Code code;
  auto& socket = beast::get_lowest_layer(stream_).socket();
  socket.set_option(boost::asio::ip::tcp::no_delay(true), code);
  socket.set_option(boost::asio::socket_base::send_buffer_size(kSendBuffer), code);
}

void WsConnection::serve(const std::string& token) {
  token_ = token;
  auto& parser = parser_.emplace();
  parser.header_limit(kMaxHeader);
  parser.body_limit(kMaxReceived);
  beast::get_lowest_layer(stream_).expires_after(kHandshake);
  http::async_read(stream_.next_layer(), received_, parser,
                   [self = shared_from_this()](Code code, std::size_t /*bytes*/) {
                     if (code || self->state_ != State::opening)
                       self->ended();
                     else
                       self->judge();
                   });
}

void WsConnection::judge() {
  const Request& request = parser_->get();
  if (!websocket::is_upgrade(request)) {
    refuse(http::status::upgrade_required, "This is a WebSocket of mien's; open it as ws://\n");
    return;
  }
  const auto view = [](beast::string_view text) { return std::string_view(text.data(), text.size()); };
  std::optional<std::string_view> origin;
  if (const auto found = request.find(http::field::origin); found != request.end())
    origin = view(found->value());
  const auto host = request[http::field::host];
  switch (judge_upgrade(view(request.target()), origin, view(host), token_)) {
    case Admission::no_token:
      refuse(http::status::unauthorized, "The address needs its ?token=\n");
      return;
    case Admission::foreign_origin:
      refuse(http::status::forbidden, "Pages of other hosts may not look at this face\n");
      return;
    case Admission::admitted:
      break;
  }
  beast::get_lowest_layer(stream_).expires_never();
  configure(beast::role_type::server);
  stream_.async_accept(request, [self = shared_from_this()](Code code) {
    if (code || self->state_ != State::opening)
      self->ended();
    else
      self->opened();
  });
}

void WsConnection::refuse(http::status status, const char* why) {
  auto& response = refusal_.emplace(status, parser_->get().version());
  response.set(http::field::content_type, "text/plain; charset=utf-8");
  if (status == http::status::upgrade_required) response.set(http::field::upgrade, "websocket");
  response.keep_alive(false);
  response.body() = why;
  response.prepare_payload();
  http::async_write(stream_.next_layer(), response,
                    [self = shared_from_this()](Code /*code*/, std::size_t /*bytes*/) { self->ended(); });
}

void WsConnection::connect(const boost::asio::ip::tcp::endpoint& endpoint, const std::string& host,
                           const std::string& target) {
  auto& lowest = beast::get_lowest_layer(stream_);
  lowest.expires_after(kHandshake);
  lowest.async_connect(endpoint, [self = shared_from_this(), host, target](Code code) {
    if (code || self->state_ != State::opening) {
      self->ended();
      return;
    }
    beast::get_lowest_layer(self->stream_).expires_never();
    self->configure(beast::role_type::client);
    self->stream_.async_handshake(host, target, [self](Code result) {
      if (result || self->state_ != State::opening)
        self->ended();
      else
        self->opened();
    });
  });
}

void WsConnection::opened() {
  parser_.reset();
  state_ = State::open;
  sending_ = *hello_;
  write();
  read();
}

bool WsConnection::offer(const std::string& message) {
  if (state_ != State::open) return false;
  if (!writing_) {
    sending_ = message;
    write();
    return true;
  }
  next_ = message;
  return !std::exchange(has_next_, true);
}

void WsConnection::write() {
  writing_ = true;
  stream_.async_write(boost::asio::buffer(sending_),
                      [self = shared_from_this()](Code code, std::size_t /*bytes*/) {
                        self->writing_ = false;
                        if (code || self->state_ != State::open) {
                          self->ended();
                          return;
                        }
                        if (!std::exchange(self->has_next_, false)) return;
                        self->sending_.swap(self->next_);
                        self->write();
                      });
}

void WsConnection::read() {
  stream_.async_read(received_, [self = shared_from_this()](Code code, std::size_t /*bytes*/) {
    if (code || self->state_ != State::open) {
      self->ended();
      return;
    }
    self->received_.consume(self->received_.size());
    self->read();
  });
}

void WsConnection::ended() {
  state_ = State::ended;
  Code code;
  beast::get_lowest_layer(stream_).socket().close(code);
}

void WsConnection::close() {
  ended();
}

}  // namespace mien::sink
