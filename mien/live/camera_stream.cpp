#include <utility>  // Before Asio 1.74, which forgets it.

#include "mien/live/camera_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/write.hpp>

#include "mien/core/ascii.h"
#include "mien/core/excerpt.h"
#include "mien/core/host_port.h"

namespace mien::live {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;
using tcp = asio::ip::tcp;

constexpr std::string_view kHttp = "http://";
constexpr std::uint16_t kHttpPort = 80;
/// What a log keeps as a source (Intake::add_source).
constexpr std::size_t kMaxAddress = 100;
/// How often it is looked whether pictures come.
constexpr auto kWatchEvery = std::chrono::milliseconds(100);
constexpr auto kHoldBack = std::chrono::milliseconds(5);

bool is_letter_of_host(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-' ||
         c == '_' || c == ':' || c == '%';
}
bool is_letter_of_path(char c) {
  return c > ' ' && c < '\x7f' && c != '#';
}

/// As the header Host and an address have it.
std::string authority_of(const CameraAddress& address) {
  const bool numbers = address.host.find(':') != std::string::npos;
  std::string text = numbers ? "[" + address.host + "]" : address.host;
  if (address.port != kHttpPort) text += fmt::format(":{}", address.port);
  return text;
}

}  // namespace

std::string CameraAddress::source() const {
  return fmt::format("{}{}{}", kHttp, authority_of(*this), path);
}

Result<CameraAddress> parse_camera_address(std::string_view text) {
  const auto bad = [&](std::string_view what) {
    return fail(ErrorCode::bad_usage, std::string(what), excerpt(text, kMaxAddress),
                "write it as http://HOST:PORT/PATH");
  };
  if (!text.starts_with(kHttp)) return bad("no address of a camera");
  if (text.size() > kMaxAddress) return bad(fmt::format("over {} letters", kMaxAddress));
  std::string_view rest = text.substr(kHttp.size());
  CameraAddress address;
  const std::size_t slash = std::min(rest.find('/'), rest.size());
  if (const auto path = rest.substr(slash); !path.empty()) address.path = path;
  rest = rest.substr(0, slash);
  if (rest.find('@') != std::string_view::npos) return bad("a user or a password, which is never sent");
  const auto host = parse_host_port(rest);
  if (!host) return bad(host.error().what);
  address.host = host->host;
  // Names of hosts know no capitals: two that differ in them are one camera.
  std::ranges::transform(address.host, address.host.begin(), ascii_lower);
  address.port = host->port.value_or(kHttpPort);
  if (address.host.empty() || !std::ranges::all_of(address.host, is_letter_of_host)) return bad("no host");
  if (address.port == 0) return bad("port 0");
  if (!std::ranges::all_of(address.path, is_letter_of_path)) return bad("the path has letters that none has");
  return address;
}

CameraStream::CameraStream(asio::io_context& network, CameraAddress address, std::string sensor,
                           std::unique_ptr<sensor::PayloadStream> stream,
                           sensor::PayloadStream::OnPayload on_payload, Clock clock, NameLookup::Ask find)
    : address_(std::move(address)),
      pictures_(address_.source(), std::move(sensor), std::move(stream), std::move(on_payload), clock),
      clock_(std::move(clock)),
      request_(fmt::format("GET {} HTTP/1.1\r\nHost: {}\r\nUser-Agent: mien\r\nConnection: close\r\n\r\n",
                           address_.path, authority_of(address_))),
      lookup_(network, std::move(find)),
      socket_(network),
      retry_(network),
      watch_(network) {
  ask();
  watch();
}

void CameraStream::ask() {
  const Attempt attempt = next_attempt();
  asking_ = true;
  finding_ = true;
  pictures_.begin();
  lookup_.find(address_.host, address_.port, [this, attempt](const NameLookup::Answer& host) {
    if (!attempt.is_over()) connect(attempt, host);
  });
}

void CameraStream::connect(const Attempt& attempt, const NameLookup::Answer& host) {
  finding_ = false;
  if (host.error)
    return lose("no such host (" + host.error.message() + "); look at its name, or give its number");
  asio::async_connect(socket_, host.found, [this, attempt](error_code failed, const tcp::endpoint&) {
    if (attempt.is_over()) return;
    if (failed) return lose("not there (" + failed.message() + "); switch it on, and look at its port");
    send_request(attempt);
  });
}

void CameraStream::send_request(const Attempt& attempt) {
  asio::async_write(socket_, asio::buffer(request_), [this, attempt](error_code code, std::size_t) {
    if (attempt.is_over()) return;
    if (code) return lose("it hung up (" + code.message() + ")");
    read(attempt);
  });
}

void CameraStream::read(const Attempt& attempt) {
  socket_.async_read_some(asio::buffer(bytes_), [this, attempt](error_code code, std::size_t size) {
    if (attempt.is_over()) return;
    if (code) return lose("it hung up (" + code.message() + ")");
    if (const auto taken = pictures_.read(std::span(bytes_).first(size)); !taken)
      return lose(taken.error().message());
    read_when_due(attempt, size);
  });
}

void CameraStream::read_when_due(const Attempt& attempt, std::size_t size) {
  if (pictures_.may_read_on(size)) return read(attempt);
  retry_.expires_after(kHoldBack);
  retry_.async_wait([this, attempt, size](error_code code) {
    if (!attempt.is_over() && !code) read_when_due(attempt, size);
  });
}

void CameraStream::watch() {
  watch_.expires_after(kWatchEvery);
  watch_.async_wait([this](error_code code) {
    if (code) return;
    if (asking_ && pictures_.is_overdue())
      lose(finding_ ? "nobody says where its host is; give its number, or look at this machine's name server"
                    : pictures_.no_picture());
    watch();
  });
}

void CameraStream::lose(const std::string& problem) {
  next_attempt();
  asking_ = false;
  error_code ignored;
  socket_.close(ignored);
  // One that gives a picture and hangs up is not asked ten times a second.
  if (pictures_.open() && clock_() - pictures_.open_since() >= CameraPictures::kPatience)
    pause_ = kFirstRetry;
  pictures_.end(problem);
  ask_again();
}

void CameraStream::ask_again() {
  retry_.expires_after(pause_);
  pause_ = std::min<std::chrono::milliseconds>(2 * pause_, kLastRetry);
  retry_.async_wait([this, attempt = next_attempt()](error_code code) {
    if (!attempt.is_over() && !code) ask();
  });
}

void CameraStream::close() {
  next_attempt();
  asking_ = false;
  error_code ignored;
  socket_.close(ignored);
  retry_.cancel();
  watch_.cancel();
}

}  // namespace mien::live
