#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/picture_server.h"

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <cmath>
#include <deque>
#include <iterator>
#include <string_view>
#include <vector>

namespace mien::live {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using tcp = asio::ip::tcp;

constexpr std::string_view kBoundary = "123456789000000000000987654321";
constexpr std::size_t kMaxRequestBytes = 8192;
constexpr auto kRequestTimeout = std::chrono::seconds(5);
/// What the system takes for a client: some thirty pictures. With its own buffers of megabytes a client that
/// reads nothing would be noticed after many seconds.
constexpr int kSendBuffer = 256 * 1024;

void add_chunk(std::string& out, std::string_view chunk) {
  fmt::format_to(std::back_inserter(out), "{:x}\r\n", chunk.size());
  out += chunk;
  out += "\r\n";
}

/// As the boards' web server sends a part: boundary, head and picture as chunks of their own.
std::string part_of(DeviceTime time, std::span<const std::byte> jpeg) {
  const auto microseconds =
      std::chrono::duration_cast<std::chrono::microseconds>(time.time_since_epoch()).count();
  std::string part;
  part.reserve(jpeg.size() + 300);
  add_chunk(part, fmt::format("\r\n--{}\r\n", kBoundary));
  add_chunk(part,
            fmt::format("Content-Type: image/jpeg\r\nContent-Length: {}\r\nX-Timestamp: {}.{:06}\r\n\r\n",
                        jpeg.size(), microseconds / 1'000'000, microseconds % 1'000'000));
  add_chunk(part, {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
  return part;
}

}  // namespace

struct PictureServer::State : std::enable_shared_from_this<PictureServer::State> {
  State(asio::io_context& context, const Settings& chosen)
      : network(context), settings(chosen), acceptor(context) {}

  void accept();
  void leave(const Client* client);

  asio::io_context& network;
  Settings settings;
  tcp::acceptor acceptor;
  std::uint16_t port = 0;
  std::vector<std::shared_ptr<Client>> clients;  // That get pictures.
  std::size_t connections = 0;                   // Those, and who has not asked yet.
  std::atomic<std::size_t> streaming = 0;
  std::atomic<std::uint64_t> pictures = 0;
  std::atomic<std::uint64_t> dropped = 0;
};

/// One who asks.
class PictureServer::Client : public std::enable_shared_from_this<PictureServer::Client> {
 public:
  using Part = std::shared_ptr<const std::string>;

  Client(tcp::socket socket, std::shared_ptr<State> state)
      : stream_(std::move(socket)), state_(std::move(state)), buffer_(kMaxRequestBytes) {
    ++state_->connections;
    parser_.header_limit(kMaxRequestBytes);
  }
  ~Client() { --state_->connections; }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void read() {
    stream_.expires_after(kRequestTimeout);
    http::async_read_header(stream_, buffer_, parser_,
                            [self = shared_from_this()](beast::error_code code, std::size_t) {
                              if (!code) self->answer();
                            });
  }
  /// False: it is too far behind.
  bool send(Part part) {
    if (waiting_.size() >= state_->settings.most_waiting) return false;
    waiting_.push_back(std::move(part));
    if (waiting_.size() == 1) write();
    return true;
  }
  void close() {
    beast::error_code ignored;
    stream_.socket().close(ignored);
  }

 private:
  void answer() {
    stream_.expires_never();
    if (parser_.get().method() != http::verb::get) return refuse("405 Method Not Allowed\r\nAllow: GET");
    if (state_->clients.size() >= kMaxClients) return refuse("503 Service Unavailable");
    beast::error_code ignored;
    stream_.socket().set_option(tcp::no_delay(true), ignored);
    stream_.socket().set_option(asio::socket_base::send_buffer_size(kSendBuffer), ignored);
    send(std::make_shared<const std::string>(
        fmt::format("HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace;boundary={}\r\n"
                    "Transfer-Encoding: chunked\r\nAccess-Control-Allow-Origin: *\r\nX-Framerate: {}\r\n\r\n",
                    kBoundary, std::lround(state_->settings.rate_hz))));
    state_->clients.push_back(shared_from_this());
    state_->streaming = state_->clients.size();
    watch();
  }
  /// Who hangs up is gone at once, not when the next picture finds nobody.
  void watch() {
    stream_.socket().async_read_some(asio::buffer(ignored_),
                                     [self = shared_from_this()](beast::error_code code, std::size_t) {
                                       if (code) return self->state_->leave(self.get());
                                       self->watch();
                                     });
  }
  void refuse(std::string_view status) {
    last_ = fmt::format("HTTP/1.1 {}\r\nContent-Length: 0\r\nConnection: close\r\n\r\n", status);
    asio::async_write(stream_, asio::buffer(last_),
                      [self = shared_from_this()](beast::error_code, std::size_t) { self->close(); });
  }
  void write() {
    asio::async_write(stream_, asio::buffer(*waiting_.front()),
                      [self = shared_from_this()](beast::error_code code, std::size_t) {
                        if (code) return self->state_->leave(self.get());
                        self->waiting_.pop_front();
                        if (!self->waiting_.empty()) self->write();
                      });
  }

  beast::tcp_stream stream_;
  std::shared_ptr<State> state_;
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
  std::deque<Part> waiting_;  // The first is being written.
  std::string last_;
  std::array<char, 256> ignored_{};  // Whatever it says while it gets pictures.
};

void PictureServer::State::accept() {
  acceptor.async_accept([self = shared_from_this()](beast::error_code code, tcp::socket socket) {
    if (code == asio::error::operation_aborted) return;
    // Who is not answered hears it at once; twice as many may be about to ask.
    if (!code && self->connections < 2 * kMaxClients)
      std::make_shared<Client>(std::move(socket), self)->read();
    self->accept();
  });
}

void PictureServer::State::leave(const Client* client) {
  std::erase_if(clients, [&](const auto& one) {
    if (one.get() != client) return false;
    one->close();
    return true;
  });
  streaming = clients.size();
}

Result<std::unique_ptr<PictureServer>> PictureServer::open(asio::io_context& network,
                                                           const Settings& settings) {
  const std::string where = fmt::format("{}:{}", settings.host, settings.port);
  beast::error_code code;
  tcp::resolver resolver(network);
  const auto found = resolver.resolve(settings.host, std::to_string(settings.port), code);
  if (code || found.empty())
    return fail(ErrorCode::not_found, code ? code.message() : "no such host", where,
                "name an address of this machine, such as 127.0.0.1");
  const tcp::endpoint endpoint = found.begin()->endpoint();
  auto state = std::make_shared<State>(network, settings);
  state->acceptor.open(endpoint.protocol(), code);
  if (!code) state->acceptor.set_option(asio::socket_base::reuse_address(true), code);
  if (!code) state->acceptor.bind(endpoint, code);
  if (!code) state->acceptor.listen(asio::socket_base::max_listen_connections, code);
  if (code)
    return fail(ErrorCode::io, fmt::format("no camera can be there: {}", code.message()), where,
                "name another port, or end what uses it");
  state->port = state->acceptor.local_endpoint().port();
  state->accept();
  return std::unique_ptr<PictureServer>(new PictureServer(std::move(state)));
}

PictureServer::~PictureServer() {
  close();
}

std::uint16_t PictureServer::port() const {
  return state_->port;
}

void PictureServer::send(DeviceTime time, std::span<const std::byte> jpeg) {
  ++state_->pictures;
  if (state_->clients.empty()) return;
  const auto part = std::make_shared<const std::string>(part_of(time, jpeg));
  state_->dropped += std::erase_if(state_->clients, [&](const std::shared_ptr<Client>& client) {
    if (client->send(part)) return false;
    client->close();
    return true;
  });
  state_->streaming = state_->clients.size();
}

void PictureServer::close() {
  beast::error_code ignored;
  state_->acceptor.close(ignored);
  for (const auto& client : state_->clients) client->close();
  state_->clients.clear();
  state_->streaming = 0;
}

PictureServer::Counts PictureServer::counts() const {
  return {.clients = state_->streaming, .pictures = state_->pictures, .dropped = state_->dropped};
}

}  // namespace mien::live
