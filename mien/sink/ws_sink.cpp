#include "mien/sink/sink_kinds.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <vector>

#include "mien/sink/frame_pace.h"
#include "mien/sink/json_frame.h"
#include "mien/sink/udp_target.h"
#include "mien/sink/ws_admission.h"
#include "mien/sink/ws_connection.h"

namespace mien::sink {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

/// Between two calls to a server that does not answer: doubled from the first to the last.
constexpr auto kFirstPause = std::chrono::milliseconds(500);
constexpr auto kLongestPause = std::chrono::seconds(4);

/// Somebody's WebSocket server.
struct Server {
  tcp::endpoint endpoint;
  std::string host;
  std::string target;
};

/// Those who are connected, and the door where more come in, or the server that is called. Its handlers
/// outlive the sink.
class Audience : public std::enable_shared_from_this<Audience> {
 public:
  Audience(boost::asio::io_context& network, std::shared_ptr<const std::string> hello, std::string token)
      : network_(&network), hello_(std::move(hello)), token_(std::move(token)), pause_end_(network) {}

  void listen(tcp::acceptor acceptor) { acceptor_.emplace(std::move(acceptor)); }
  /// Waits for the next who comes; again when the machine has failed to let one in.
  void accept() {
    if (!acceptor_ || accepting_) return;
    accepting_ = true;
    acceptor_->async_accept([self = shared_from_this()](error_code code, tcp::socket socket) {
      self->accepting_ = false;
      if (code || !self->acceptor_) return;
      self->remove_ended();
      if (self->connections_.size() < kMaxWsClients) {
        self->connections_.push_back(std::make_shared<WsConnection>(std::move(socket), self->hello_));
        self->connections_.back()->serve(self->token_);
      }
      self->accept();
    });
  }
  /// Calls the server now, and again whenever there is no line to it, until close().
  void keep_calling(Server server) {
    server_.emplace(std::move(server));
    call_when_alone();
  }
  void remove_ended() {
    std::erase_if(connections_, [](const auto& connection) { return connection->is_ended(); });
  }
  void close() {
    error_code code;
    if (acceptor_) acceptor_->close(code);
    acceptor_.reset();
    server_.reset();
    pause_end_.cancel();
    for (const auto& connection : connections_) connection->close();
    connections_.clear();
  }

  [[nodiscard]] bool calls() const { return server_.has_value(); }
  /// The first call is not answered yet, nor refused.
  [[nodiscard]] bool calls_first() const {
    return calls_ == 1 && !connections_.empty() && !connections_.back()->is_ended();
  }
  [[nodiscard]] std::size_t open_count() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(connections_, [](const auto& connection) { return connection->is_open(); }));
  }
  /// True when somebody takes it without having to skip another for it.
  bool offer(const std::string& message) {
    bool any = false;
    for (const auto& connection : connections_) any = connection->offer(message) || any;
    return any;
  }

 private:
  void call_when_alone() {
    remove_ended();
    if (open_count() > 0) pause_ = kFirstPause;
    pause_end_.expires_after(pause_);
    if (connections_.empty()) {
      connections_.push_back(std::make_shared<WsConnection>(tcp::socket(*network_), hello_));
      connections_.back()->connect(server_->endpoint, server_->host, server_->target);
      ++calls_;
      pause_ = std::min<std::chrono::milliseconds>(2 * pause_, kLongestPause);
    }
    pause_end_.async_wait([self = shared_from_this()](error_code code) {
      if (!code && self->server_) self->call_when_alone();
    });
  }

  boost::asio::io_context* network_;
  std::shared_ptr<const std::string> hello_;
  std::string token_;
  std::optional<Server> server_;
  std::chrono::milliseconds pause_ = kFirstPause;
  boost::asio::steady_timer pause_end_;
  std::uint64_t calls_ = 0;
  std::optional<tcp::acceptor> acceptor_;
  bool accepting_ = false;
  std::vector<std::shared_ptr<WsConnection>> connections_;
};

class WsSink final : public Sink {
 public:
  WsSink(std::string address, int rate_hz, std::shared_ptr<Audience> audience)
      : address_(std::move(address)), pace_(rate_hz), audience_(std::move(audience)) {}
  ~WsSink() override { audience_->close(); }

  void send(const face::OutputFrame& frame, std::int64_t frame_index) noexcept override {
    try {
      audience_->remove_ended();
      audience_->accept();
      if (!pace_.due(frame_index)) return;
      if (audience_->open_count() == 0) {
        // Nobody has come yet, which is nobody's failure; a server that is not there is.
        if (audience_->calls()) pace_.failed();
        return;
      }
      write_frame_json(frame, frame_index, nullptr, message_);
      if (audience_->offer(message_))
        pace_.sent();
      else
        pace_.failed();
    } catch (...) {  // Out of memory: the frame is lost.
      pace_.failed();
    }
  }

  Status status() const override {
    const std::size_t receivers = audience_->open_count();
    const char* note = "";
    if (receivers == 0)
      note = audience_->calls_first() ? "connecting"
             : audience_->calls()     ? "no WebSocket answers there; trying again and again"
                                      : "waiting for somebody to connect";
    return {address_, pace_.sent_count(), pace_.failed_count(), pace_.measured_hz(), receivers, note};
  }

 private:
  std::string address_;
  FramePace pace_;
  std::shared_ptr<Audience> audience_;
  std::string message_;
};

/// A door at that address, or why there is none.
std::optional<tcp::acceptor> open_door(boost::asio::io_context& network, const tcp::endpoint& endpoint,
                                       error_code& code) {
  tcp::acceptor acceptor(network);
  acceptor.open(endpoint.protocol(), code);
  if (!code) acceptor.set_option(boost::asio::socket_base::reuse_address(true), code);
  if (!code) acceptor.bind(endpoint, code);
  if (!code) acceptor.listen(boost::asio::socket_base::max_listen_connections, code);
  if (code) return std::nullopt;
  return acceptor;
}

}  // namespace

Result<std::unique_ptr<Sink>> open_ws_sink(boost::asio::io_context& network, const Address& address,
                                           std::string_view text) {
  MIEN_TRY(address.expect_options({"token", "role", "rate"}));
  MIEN_TRY_ASSIGN(const int rate_hz, address.whole_option("rate", 60, 1, 60));
  const std::string* const role = address.option("role");
  if (role != nullptr && *role != "connect" && *role != "listen")
    return fail(ErrorCode::bad_usage, fmt::format("the role '{}' is neither connect nor listen", *role),
                std::string(text));
  const std::string* const given = address.option("token");
  if (given != nullptr && !is_token(*given))
    return fail(ErrorCode::bad_usage, "a token has 8 to 128 letters, digits, or - . _ ~", std::string(text));
  const std::string token = given == nullptr ? std::string() : *given;

  const std::string where = address.endpoint(kWsPort);
  MIEN_TRY_ASSIGN(const auto host, find_host(network, address, kWsPort));
  const tcp::endpoint endpoint(host, address.port == 0 ? kWsPort : address.port);

  const auto hello = std::make_shared<const std::string>(hello_json({.software = "mien " MIEN_VERSION}));
  const auto audience = std::make_shared<Audience>(network, hello, token);
  if (role == nullptr || *role == "listen") {
    error_code code;
    auto door = open_door(network, endpoint, code);
    if (door) {
      if (!endpoint.address().is_loopback() && token.empty())
        return fail(ErrorCode::bad_usage, "without a token the whole network could look at the face",
                    std::string(text), "add ?token=, of 8 letters or more, or listen on 127.0.0.1");
      audience->listen(*std::move(door));
      audience->accept();
      return std::make_unique<WsSink>(std::string(text), rate_hz, audience);
    }
    if (role != nullptr) return fail(ErrorCode::io, "cannot listen there: " + code.message(), where);
  }
  std::string target = address.path.empty() ? "/" : address.path;
  if (!token.empty()) target += "?token=" + token;
  audience->keep_calling({endpoint, where, std::move(target)});
  return std::make_unique<WsSink>(std::string(text), rate_hz, audience);
}

}  // namespace mien::sink
