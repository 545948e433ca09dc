#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/page_server.h"

#include <fmt/format.h>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>
#include <map>
#include <optional>

#include "mien/core/host_port.h"
#include "mien/core/secret.h"
#include "mien/sink/ws_admission.h"

namespace mien::live {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;

constexpr std::size_t kMaxConnections = 64;
constexpr std::size_t kMaxRequestBytes = std::size_t{1} << 14U;
constexpr std::size_t kMaxMessageBytes = std::size_t{1} << 16U;
/// Replies and states that a client may be behind.
constexpr std::size_t kMaxQueue = 256;
constexpr auto kIdleTimeout = std::chrono::seconds(15);
/// How often a request looks whether what it waits for is made.
constexpr auto kLookAgain = std::chrono::milliseconds(20);

std::string_view view(beast::string_view text) {
  return {text.data(), text.size()};
}

}  // namespace

struct PageServer::State : std::enable_shared_from_this<PageServer::State> {
  State(asio::io_context& context, PageSettings s)
      : network(context), settings(std::move(s)), acceptor(context) {}

  void accept();
  /// Null where it is gone.
  [[nodiscard]] std::shared_ptr<Connection> find(std::uint64_t client) const {
    const auto found = clients.find(client);
    return found == clients.end() ? nullptr : found->second.lock();
  }
  [[nodiscard]] bool knows_token(std::string_view token) const;
  [[nodiscard]] bool knows_host(const http::request<http::empty_body>& request) const;
  [[nodiscard]] bool allows_origin(const http::request<http::empty_body>& request) const;

  asio::io_context& network;
  PageSettings settings;
  OnOpen on_open;
  OnMessage on_message;
  OnBytes on_bytes;
  tcp::acceptor acceptor;
  bool loopback = true;
  std::uint64_t next_client = 1;
  std::size_t connections = 0;
  std::map<std::uint64_t, std::weak_ptr<Connection>> clients;
};

/// One browser's connection: requests one after the other, and perhaps a WebSocket at their end.
class PageServer::Connection : public std::enable_shared_from_this<PageServer::Connection> {
 public:
  Connection(tcp::socket socket, std::shared_ptr<State> state)
      : stream_(std::move(socket)),
        look_again_(stream_.get_executor()),
        state_(std::move(state)),
        buffer_(kMaxRequestBytes) {
    ++state_->connections;
  }
  ~Connection() {
    --state_->connections;
    if (client_ != 0) state_->clients.erase(client_);
  }

  void read() {
    parser_.emplace();
    parser_->header_limit(kMaxRequestBytes);
    stream_.expires_after(kIdleTimeout);
    http::async_read_header(stream_, buffer_, *parser_,
                            [self = shared_from_this()](beast::error_code code, std::size_t) {
                              if (!code) self->answer();
                            });
  }

  void send_frame(const std::shared_ptr<const std::string>& frame) {
    frame_ = frame;
    write();
  }
  void send(const std::shared_ptr<const std::string>& message) {
    if (queue_.size() >= kMaxQueue) {
      beast::get_lowest_layer(*socket_).close();  // It listens no more.
      return;
    }
    queue_.push_back(message);
    write();
  }
  void send_picture(std::uint16_t camera, std::shared_ptr<const std::string> message) {
    pictures_[camera] = std::move(message);
    write();
  }
  /// Counts from the next message that is read.
  void allow_messages(std::size_t bytes) { longest_message_ = bytes; }

 private:
  void answer() {
    const http::request<http::empty_body> request = parser_->get();
    const std::string_view target = view(request.target());
    const std::string_view path = target.substr(0, target.find('?'));
    const std::string_view token = sink::token_of(target);
    if (!state_->knows_host(request))
      return refuse(http::status::forbidden,
                    "open it as http://127.0.0.1 with the port that mien live printed");
    if (websocket::is_upgrade(request)) {
      if (path != "/ws") return refuse(http::status::not_found, "no such page");
      if (!state_->knows_token(token)) return refuse(http::status::forbidden, "a token is missing or wrong");
      if (!state_->allows_origin(request)) return refuse(http::status::forbidden, "a page from elsewhere");
      return open_socket(request);
    }
    if (request.method() != http::verb::get && request.method() != http::verb::head)
      return refuse(http::status::method_not_allowed, "only GET");
    const std::string_view wanted = path == "/" ? std::string_view("/index.html") : path;
    for (const Asset& asset : state_->settings.assets)
      if (asset.path == wanted) {
        // The page's own files hold nothing of the session, and a page cannot put a token into their
        // addresses.
        if (!asset.open && !state_->knows_token(token))
          return refuse(http::status::forbidden, "a token is missing or wrong");
        return asset.make ? give_when_made(asset, request) : give(asset, asset.bytes, request);
      }
    refuse(http::status::not_found, "no such page");
  }

  void give_when_made(const Asset& asset, const http::request<http::empty_body>& request) {
    const auto made = asset.make();
    if (made.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
      look_again_.expires_after(kLookAgain);
      look_again_.async_wait([self = shared_from_this(), &asset, request](beast::error_code code) {
        if (!code) self->give_when_made(asset, request);
      });
      return;
    }
    if (!made.get()) return refuse(http::status::internal_server_error, made.get().error().message());
    give(asset, *made.get(), request);
  }

  void give(const Asset& asset, std::span<const std::byte> bytes,
            const http::request<http::empty_body>& request) {
    auto response = std::make_shared<http::response<http::span_body<const char>>>(
        std::piecewise_construct,
        std::make_tuple(beast::span<const char>(reinterpret_cast<const char*>(bytes.data()),
                                                request.method() == http::verb::head ? 0 : bytes.size())),
        std::make_tuple(http::status::ok, request.version()));
    response->set(http::field::content_type, beast::string_view(asset.type.data(), asset.type.size()));
    response->set(http::field::cache_control, "no-cache");
    response->set("X-Content-Type-Options", "nosniff");
    response->set("X-Frame-Options", "DENY");
    response->set("Referrer-Policy", "no-referrer");
    response->set("Content-Security-Policy",
                  "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; "
                  "connect-src 'self' blob: data:; worker-src 'self' blob:; object-src 'none'; "
                  "frame-ancestors 'none'; base-uri 'none'");
    response->content_length(bytes.size());
    response->keep_alive(request.keep_alive());
    stream_.expires_after(4 * kIdleTimeout);
    http::async_write(stream_, *response,
                      [self = shared_from_this(), response](beast::error_code code, std::size_t) {
                        if (code || response->need_eof())
                          self->stream_.close();
                        else
                          self->read();
                      });
  }

  void refuse(http::status status, std::string_view why) {
    auto response = std::make_shared<http::response<http::string_body>>(status, parser_->get().version());
    response->set(http::field::content_type, "text/plain; charset=utf-8");
    response->body() = fmt::format("{}\n", why);
    response->prepare_payload();
    response->keep_alive(false);
    stream_.expires_after(kIdleTimeout);
    http::async_write(
        stream_, *response,
        [self = shared_from_this(), response](beast::error_code, std::size_t) { self->stream_.close(); });
  }

  void open_socket(const http::request<http::empty_body>& request) {
    stream_.expires_never();
    socket_.emplace(std::move(stream_));
    socket_->set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
    socket_->async_accept(request, [self = shared_from_this()](beast::error_code code) {
      if (code) return;
      self->client_ = self->state_->next_client++;
      self->state_->clients[self->client_] = self;
      self->send(std::make_shared<const std::string>(self->state_->on_open()));
      self->read_message();
    });
  }

  void read_message() {
    socket_->read_message_max(longest_message_);
    message_.max_size(longest_message_);
    socket_->async_read(message_, [self = shared_from_this()](beast::error_code code, std::size_t) {
      if (code) return;
      const auto data = self->message_.cdata();
      if (self->socket_->got_text())
        self->state_->on_message(self->client_, {static_cast<const char*>(data.data()), data.size()});
      else if (self->state_->on_bytes)
        self->state_->on_bytes(self->client_, {static_cast<const std::byte*>(data.data()), data.size()});
      self->message_.consume(self->message_.size());
      self->read_message();
    });
  }

  void write() {
    if (writing_ || (queue_.empty() && !frame_ && pictures_.empty())) return;
    std::shared_ptr<const std::string> message;
    const bool is_text = !queue_.empty() || frame_;
    if (!queue_.empty()) {
      message = queue_.front();
      queue_.pop_front();
    } else if (frame_) {
      message = std::move(frame_);
      frame_.reset();
    } else {
      message = std::move(pictures_.extract(pictures_.begin()).mapped());
    }
    writing_ = true;
    socket_->text(is_text);
    socket_->async_write(asio::buffer(*message),
                         [self = shared_from_this(), message](beast::error_code code, std::size_t) {
                           self->writing_ = false;
                           if (!code) self->write();
                         });
  }

  beast::tcp_stream stream_;
  asio::steady_timer look_again_;
  std::shared_ptr<State> state_;
  beast::flat_buffer buffer_;
  beast::flat_buffer message_{kMaxMessageBytes};
  std::optional<http::request_parser<http::empty_body>> parser_;
  std::optional<websocket::stream<beast::tcp_stream>> socket_;
  std::uint64_t client_ = 0;
  std::size_t longest_message_ = kMaxMessageBytes;
  bool writing_ = false;
  std::deque<std::shared_ptr<const std::string>> queue_;
  std::shared_ptr<const std::string> frame_;  // The newest that has not been sent, ...
  std::map<std::uint16_t, std::shared_ptr<const std::string>> pictures_;  // ... and of each camera.
};

bool PageServer::State::knows_token(std::string_view token) const {
  return settings.token.empty() || same_secret(token, settings.token);
}

bool PageServer::State::knows_host(const http::request<http::empty_body>& request) const {
  // A page from elsewhere can make a browser call a loopback address by another name; with a token it gains
  // nothing.
  return !settings.token.empty() || is_loopback(host_of(view(request[http::field::host])));
}

bool PageServer::State::allows_origin(const http::request<http::empty_body>& request) const {
  const std::string_view origin = view(request[http::field::origin]);
  if (origin.empty()) return true;                // No browser.
  const std::size_t scheme = origin.find("://");  // https where a proxy stands before us.
  return scheme != std::string_view::npos && origin.substr(scheme + 3) == view(request[http::field::host]);
}

void PageServer::State::accept() {
  acceptor.async_accept([self = shared_from_this()](beast::error_code code, tcp::socket socket) {
    if (code == asio::error::operation_aborted) return;
    if (!code && self->connections < kMaxConnections)
      std::make_shared<Connection>(std::move(socket), self)->read();
    self->accept();
  });
}

PageServer::PageServer(std::shared_ptr<State> state) : state_(std::move(state)) {}

PageServer::~PageServer() {
  beast::error_code ignored;
  state_->acceptor.close(ignored);
  // What is still in flight finds nobody to tell.
  state_->on_message = [](std::uint64_t, std::string_view) {};
  state_->on_bytes = {};
  state_->on_open = [] { return std::string(); };
}

Result<std::unique_ptr<PageServer>> PageServer::open(asio::io_context& network, PageSettings settings,
                                                     OnOpen on_open, OnMessage on_message, OnBytes on_bytes) {
  const std::string where = fmt::format("{}:{}", settings.host, settings.port);
  beast::error_code code;
  const asio::ip::address address = settings.host == "localhost"
                                        ? asio::ip::address(asio::ip::address_v4::loopback())
                                        : asio::ip::make_address(settings.host, code);
  if (code)
    return fail(ErrorCode::bad_usage, "the page's address is no IP address", where,
                "give one of this machine's, as 127.0.0.1:8740 or 0.0.0.0:8740");
  auto state = std::make_shared<State>(network, std::move(settings));
  state->loopback = address.is_loopback();
  if (!state->loopback && state->settings.token.empty())
    return fail(ErrorCode::bad_usage, "the page would be open to the whole network", where,
                "give a token, or bind it to 127.0.0.1");
  state->on_open = std::move(on_open);
  state->on_message = std::move(on_message);
  state->on_bytes = std::move(on_bytes);
  const tcp::endpoint endpoint(address, state->settings.port);
  state->acceptor.open(endpoint.protocol(), code);
  if (!code) state->acceptor.set_option(asio::socket_base::reuse_address(true), code);
  if (!code) state->acceptor.bind(endpoint, code);
  if (!code) state->acceptor.listen(asio::socket_base::max_listen_connections, code);
  if (code)
    return fail(ErrorCode::bad_usage, "the page cannot be served there: " + code.message(), where,
                "give another with --page HOST:PORT, or --page off");
  state->accept();
  return std::unique_ptr<PageServer>(new PageServer(std::move(state)));
}

std::string PageServer::address() const {
  const tcp::endpoint endpoint = state_->acceptor.local_endpoint();
  std::string host = endpoint.address().to_string();
  if (endpoint.address().is_v6()) host = "[" + host + "]";
  const std::string& token = state_->settings.token;
  return fmt::format("http://{}:{}/{}{}", host, endpoint.port(), token.empty() ? "" : "?token=", token);
}

std::size_t PageServer::clients() const {
  return state_->clients.size();
}

bool PageServer::has(std::uint64_t client) const {
  return state_->clients.contains(client);
}

void PageServer::send_frame(std::string frame) {
  const auto shared = std::make_shared<const std::string>(std::move(frame));
  for (const auto& [number, client] : state_->clients)
    if (const auto there = client.lock()) there->send_frame(shared);
}

void PageServer::send(std::string message) {
  const auto shared = std::make_shared<const std::string>(std::move(message));
  for (const auto& [number, client] : state_->clients)
    if (const auto there = client.lock()) there->send(shared);
}

void PageServer::allow_messages(std::uint64_t client, std::size_t bytes) {
  if (const auto there = state_->find(client)) there->allow_messages(bytes);
}

void PageServer::send_picture(std::uint64_t client, std::uint16_t camera, std::string message) {
  if (const auto there = state_->find(client))
    there->send_picture(camera, std::make_shared<const std::string>(std::move(message)));
}

void PageServer::send(std::uint64_t client, std::string message) {
  if (const auto there = state_->find(client))
    there->send(std::make_shared<const std::string>(std::move(message)));
}

}  // namespace mien::live
